#include "app/commands/typed_board.h"

#include "app/commands/common_options.h"
#include "base/input_error.h"

#include <CLI/CLI.hpp>

namespace springdrive::app {

void TypedBoard::add_to(CLI::App &command) {
    add_device_option(command, device);
    add_device_file_option(command, device_file);
    command
        .add_option("--true-device-file", true_device_file,
                    "what the simulated device is, if it is another one [the device file]")
        ->type_name("FILE");
    command.add_option("--device-seed", device_seed,
                       "the simulated device's motors and sensors deviate at random [0: none]");
    command
        .add_option("--fault", faults,
                    "what fails of the simulated device, as in springdrive device emulate; may "
                    "be repeated")
        ->type_name("FAULT");
}

factory::BoardRequest TypedBoard::request() const {
    const NamedDevice named = device_named(device);
    factory::BoardRequest request;
    request.kind = named.kind;
    request.serial = named.serial;
    request.description = device::read_device_file(device_file);
    if (named.kind == factory::DeviceKind::usb) {
        if (!(true_device_file.empty() && device_seed == 0 && faults.empty())) {
            throw InputError("--true-device-file, --device-seed and --fault: are for the "
                             "simulated device; remove them, or --device usb");
        }
        return request;
    }
    request.truth =
        true_device_file.empty() ? request.description : device::read_device_file(true_device_file);
    request.emulation.simulation.device_seed = device_seed;
    request.emulation.identity =
        emulator::emulated_identity(simulated::simulated_identity(device_seed).serial);
    request.emulation.start_tip_m = Vector3::Zero();
    for (const std::string &fault : faults) {
        request.emulation.faults.push_back(emulator::parse_fault(fault));
    }
    return request;
}

} // namespace springdrive::app
