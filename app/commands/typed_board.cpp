#include "app/commands/typed_board.h"

#include "app/host/user_folder.h"
#include "base/input_error.h"
#include "device/core/device_file.h"
#include "engine/session/windings_file.h"

namespace springdrive::app {

void TypedBoard::add_to(Command &command) {
    add_device_option(command, device);
    add_device_file_option(command, device_file);
    emulation.add_to(command, "simulated device");
    command.add_option("--device-seed", device_seed,
                       "the simulated device's motors and sensors deviate at random [0: none]");
}

factory::BoardRequest TypedBoard::request() const {
    const NamedDevice named = device_named(device);
    factory::BoardRequest request;
    request.kind = named.kind;
    request.serial = named.serial;
    request.description = device::read_device_file(device_file);
    if (named.kind == factory::DeviceKind::usb) {
        if (!(emulation.is_empty() && device_seed == 0)) {
            throw InputError("--true-device-file, --device-seed and --fault: are for the "
                             "simulated device; remove them, or --device usb");
        }
        return request;
    }
    request.truth = emulation.truth().value_or(request.description);
    request.emulation.simulation.device_seed = device_seed;
    request.emulation.identity =
        emulator::emulated_identity(named.kind == factory::DeviceKind::emulated
                                        ? factory::emulated_serial(device_seed)
                                        : simulated::simulated_identity(device_seed).serial);
    request.emulation.start_tip_m = Vector3::Zero();
    request.emulation.faults = emulation.parsed_faults();
    return request;
}

factory::OpenBoard open_to_drive(const factory::BoardRequest &request) {
    factory::OpenBoard board = factory::open_board(request);
    if (!board.emulated) {
        static_cast<void>(session::take_windings(windings_folder(), board.device->identity().serial,
                                                 board.device->description().motor,
                                                 session::storing_time()));
    }
    return board;
}

} // namespace springdrive::app
