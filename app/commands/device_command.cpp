#include "app/commands/commands.h"

#include "app/commands/commissioning_commands.h"
#include "app/commands/common_options.h"
#include "app/host/ending_signal.h"
#include "base/input_error.h"
#include "base/print.h"
#include "base/text.h"
#include "device/core/device_file.h"
#include "device/factory/device_factory.h"
#include "device/simulated/hand_tours.h"
#include "device/usb/emulator/emulated_board.h"
#include "device/usb/emulator/gadget.h"

#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

namespace springdrive::app {

namespace {

void list_devices() {
    for (const factory::PresentDevice &device : factory::devices_present()) {
        std::string name(factory::kDeviceKindNames[static_cast<std::size_t>(device.kind)]);
        if (device.kind == factory::DeviceKind::usb) { // of the others, there is one each
            name += ":" + (device.serial.empty() ? "?" : one_line(device.serial));
        }
        print(std::cout, "{}{}{}\n", name, device.problem.empty() ? "" : "  ", device.problem);
    }
}

struct TypedEmulator {
    std::filesystem::path device_file;
    EffectOptions effects;
    std::filesystem::path path;
    double tour_s = 0.0; ///< when it begins; 0: none
    std::string serial = "emulated";
    std::string clock = "wall";
    std::string controller;
    std::string speed = "high";
    double delay_periods = 0.3;
    double loop_hz = 40'000.0;
    double seconds = 0.0;
    std::uint64_t seed = 1;
    std::vector<std::string> faults;
};

emulator::EmulatedBoardOptions board_options(const TypedEmulator &typed,
                                             const device::DeviceDescription &description) {
    check_range("--delay", typed.delay_periods, 0.0, emulator::EmulatedBoard::kMaxDelay_periods);
    check_range("--loop-hz", typed.loop_hz, 1000.0, 200'000.0);
    emulator::EmulatedBoardOptions options;
    options.identity = emulator::emulated_identity(typed.serial);
    options.settings.loop_rate_hz = static_cast<std::uint32_t>(std::lround(typed.loop_hz));
    options.clock =
        typed.clock == "frame" ? emulator::BoardClock::frame : emulator::BoardClock::wall;
    options.delay_periods = typed.delay_periods;
    options.simulation.effects = typed.effects.effects();
    options.simulation.device_seed = typed.effects.device_seed;
    if (!typed.path.empty()) {
        options.simulation.path = simulated::HandPath::read_csv(typed.path);
        options.start_tip_m = options.simulation.path->points().front().position_m;
    }
    if (typed.tour_s != 0.0) {
        check_range("--tour", typed.tour_s, 0.1, 3600.0);
        options.start_tip_m = Vector3::Zero();
        options.simulation.path = simulated::stop_tour(description, Vector3::Zero(), typed.tour_s);
    }
    options.seed = typed.seed;
    for (const std::string &fault : typed.faults) {
        options.faults.push_back(device::parse_fault(fault));
    }
    return options;
}

/// Plugs and unplugs the device as its faults want it, until the end.
void emulate(const TypedEmulator &typed) {
    check_range("--seconds", typed.seconds, 0.0, 24.0 * 3600.0);
    const device::DeviceDescription description = device::read_device_file(typed.device_file);
    emulator::EmulatedBoard board(description, board_options(typed, description));
    emulator::GadgetOptions options;
    options.serial = typed.serial;
    options.controller = typed.controller;
    options.is_high_speed = typed.speed == "high";
    note_ending_signals();
    emulator::Gadget gadget(board, options);
    const double until_s = board.time_s() + typed.seconds;
    const auto ends = [&] {
        return asked_to_end() || (typed.seconds > 0.0 && board.time_s() >= until_s);
    };
    while (!ends()) {
        gadget.plug_in();
        print(std::cout, "{} is plugged in at {}\n", typed.serial, gadget.controller());
        std::cout.flush();
        gadget.run([&] { return ends() || board.unplug_wanted(); });
        gadget.unplug();
        print(std::cout, "{} is unplugged at {:.3f} s\n", typed.serial, board.time_s());
        std::cout.flush();
        gadget.run([&] { return ends() || !board.unplug_wanted(); });
    }
    if (board.late_s() > 0.0) {
        print(std::cerr,
              "this computer was too slow by {:.3f} s of {:.3f} s; a lower --loop-hz, or --clock "
              "frame\n",
              board.late_s(), board.time_s());
    }
}

void add_emulate(Command &device) {
    Command command = device.add_subcommand(
        "emulate", "be a USB device: a board with the simulated PHANTOM behind it");
    const auto typed = std::make_shared<TypedEmulator>();
    add_device_file_option(command, typed->device_file);
    typed->effects.add_to(command);
    command
        .add_option("--path", typed->path,
                    "the hand's target, a CSV file with columns t,x,y,z [s, m]; its first point is "
                    "where the tip is at power-up")
        .type_name("FILE");
    command
        .add_option("--tour", typed->tour_s,
                    "the hand rests in the zero pose for S seconds since power-up, then moves the "
                    "device from stop to stop, as springdrive device self-test asks for")
        .type_name("S")
        .excludes(command.get_option("--path"));
    command.add_option("--serial", typed->serial, "serial number [emulated]").type_name("TEXT");
    command
        .add_option("--clock", typed->clock,
                    "wall: real time; frame: a period passes with each packet from the host, so "
                    "that a run is repeatable [wall]")
        .one_of({"wall", "frame"});
    command
        .add_option("--delay", typed->delay_periods,
                    "by the frame clock: d, from a measurement to the command computed from it, in "
                    "periods [0.3]")
        .type_name("D");
    command.add_option("--loop-hz", typed->loop_hz, "rate of the amplifiers' loop [40000]")
        .type_name("HZ");
    command.add_option("--speed", typed->speed, "of the connection: high or full [high]")
        .one_of({"high", "full"});
    command
        .add_option("--controller", typed->controller,
                    "USB device controller, a name in /sys/class/udc [the first]")
        .type_name("NAME");
    command
        .add_option(
            "--fault", typed->faults,
            "what fails, NAME[:ARGUMENT...][@BEGIN[-END]], times in seconds since power-up; "
            "may be repeated")
        .type_name("FAULT");
    command.add_option("--seed", typed->seed, "of faults that strike at random [1]");
    command.add_option("--seconds", typed->seconds, "ends after these; 0: by Ctrl+C [0]")
        .type_name("S");
    command.footer("Needs root, and a USB device controller: modprobe dummy_hcd gives a virtual "
                   "one.\nFaults:\n" +
                   device::fault_usage());
    command.callback([typed] { emulate(*typed); });
}

} // namespace

void add_device_command(Command &app) {
    Command device =
        app.add_subcommand("device", "devices: list, ask, test and calibrate them, emulate one");
    device.require_subcommand();
    device.add_subcommand("list", "the devices that are there, as --device names them")
        .callback(list_devices);
    add_info(device);
    add_self_test(device);
    add_calibrate(device);
    add_sweep(device);
    add_emulate(device);
}

} // namespace springdrive::app
