// The command `device`, and its subcommands `list`, `sweep` and `emulate`.
#include "app/commands/command.h"
#include "app/commands/commissioning_commands.h"
#include "app/commands/common_options.h"
#include "app/commands/output_files.h"
#include "app/figures/gnuplot.h"
#include "app/host/process.h"
#include "base/degrees.h"
#include "base/input_error.h"
#include "base/new_file.h"
#include "base/print.h"
#include "base/table.h"
#include "base/text.h"
#include "device/core/device_description.h"
#include "device/core/device_file.h"
#include "device/factory/device_factory.h"
#include "device/simulated/hand_tours.h"
#include "device/usb/emulator/emulated_board.h"
#include "device/usb/emulator/gadget.h"
#include "engine/commissioning/sweep.h"
#include "engine/lab/loops/rendered_stiffness.h"
#include "engine/servo/real_time.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app {

namespace {

using commissioning::MotorSweep;
using commissioning::StiffnessSweep;
using commissioning::SweepOptions;
using commissioning::SweepPoint;
using commissioning::SweepReport;
using commissioning::SweepStage;

std::string settings_text(const SweepOptions &options) {
    const control::Tuning &tuning = options.tuning;
    return fmt::format("dR {:.4g} Ω, K_P {:.4g} V/rad, K_D {:.4g} V·s/rad, λ {:.4g} rad/s, servo "
                       "{:.5g} Hz",
                       tuning.dR_Ohm, tuning.K_P_V_per_rad, tuning.K_D_Vs_per_rad,
                       tuning.lambda_rad_per_s, options.servo_hz);
}

Table table_of(const MotorSweep &sweep) {
    Table table = Table::with_columns(
        "freq_hz:.4g,measured\n|K_θ|:.5f,phase,sampled\n|K_θ|:.5f,phase,(12)\n|K_θ|:.5f,phase,"
        "measured to sampled\n%,deg,+-%,:",
        ".2f");
    for (const SweepPoint &point : sweep.points) {
        table.rows.push_back(
            {point.frequency_hz, std::abs(point.measured_Nm_per_rad),
             loops::phase_deg(point.measured_Nm_per_rad), std::abs(point.sampled_Nm_per_rad),
             loops::phase_deg(point.sampled_Nm_per_rad), std::abs(point.analytic_Nm_per_rad),
             loops::phase_deg(point.analytic_Nm_per_rad), 100.0 * point.magnitude_error(),
             kDegreesPerRadian * point.phase_error_rad(), 100.0 * point.deviation,
             point.deviation <= commissioning::kUncertain ? "" : "?"});
    }
    return table;
}

/// For people.
void write_sweep_table(std::ostream &out, const device::DeviceDescription &device,
                       const SweepOptions &options, const SweepReport &report) {
    print(out, "{}: {}\n", device.name, settings_text(options));
    for (const MotorSweep &sweep : report.motors) {
        const device::MotorParameters &file = device.motor[sweep.motor];
        print(out,
              "\nmotor {}: dR {:.4f} Ω, L {:.3f} mH (file {:.3f}), k_T {:.2f} mN·m/A (file "
              "{:.2f}), d {:.3f} periods\n",
              sweep.motor + 1, sweep.winding.dR_Ohm, 1e3 * sweep.winding.inductance_H,
              1e3 * file.inductance_H, 1e3 * sweep.winding.torque_constant_Nm_per_A,
              1e3 * file.torque_constant_Nm_per_A, sweep.points.front().delay_periods);
        write_text(out, table_of(sweep));
    }
    if (report.is_complete && !report.is_certain()) {
        print(out,
              "\n?  known to more than {:.0f} % only: hardly any force flows there; hold the "
              "tip more firmly, or allow more force or motion\n",
              100.0 * commissioning::kUncertain);
    }
}

/// For programs: a row a motor and frequency.
Table sweep_table(const SweepReport &report) {
    Table table = Table::with_columns(
        "motor,freq_hz,measured_mag,measured_phase_deg,deviation_percent,sampled_mag,"
        "sampled_phase_deg,analytic_mag,analytic_phase_deg,magnitude_error_percent,"
        "phase_error_deg,delay_periods,excitation_V",
        ".9g");
    for (const MotorSweep &sweep : report.motors) {
        for (const SweepPoint &point : sweep.points) {
            table.rows.push_back(
                {sweep.motor + 1, point.frequency_hz, std::abs(point.measured_Nm_per_rad),
                 loops::phase_deg(point.measured_Nm_per_rad), 100.0 * point.deviation,
                 std::abs(point.sampled_Nm_per_rad), loops::phase_deg(point.sampled_Nm_per_rad),
                 std::abs(point.analytic_Nm_per_rad), loops::phase_deg(point.analytic_Nm_per_rad),
                 100.0 * point.magnitude_error(), kDegreesPerRadian * point.phase_error_rad(),
                 point.delay_periods, point.excitation_V});
        }
    }
    return table;
}

/// @throw InputError as `draw` and `write_output` do
void draw_sweep(const std::filesystem::path &svg, const std::string &device_text,
                const SweepOptions &options, const SweepReport &report, Existing existing) {
    write_output(
        numbers_of(svg).string(), [&](std::ostream &out) { write_csv(out, sweep_table(report)); },
        existing);
    ChartMarks marks;
    marks.add("heading", "Rendered stiffness K_θ by sine sweep, " + device_text);
    marks.add("setting",
              settings_text(options) +
                  fmt::format(", d {:.3f}", report.motors.front().points.front().delay_periods));
    draw_numbers(svg, "device_sweep", marks, existing);
}

struct TypedSweep {
    TypedBoard board;
    TuningOptions tuning;
    std::vector<int> motors{1, 2, 3};
    SweepOptions options;
    std::optional<double> tolerance; ///< in % and degrees
    std::string csv;                 ///< empty: not requested
    std::filesystem::path svg;       ///< the same
    Existing existing = Existing::keep;
};

SweepOptions checked_options(const TypedSweep &typed, const device::DeviceDescription &device) {
    SweepOptions options = typed.options;
    options.tuning = typed.tuning.tuning();
    check_dR(device, options.tuning);
    if (typed.tolerance) {
        check_range("--tolerance", *typed.tolerance, 0.01, 100.0);
    }
    options.motors.clear();
    for (const int motor : typed.motors) {
        check_range("--motors", motor, 1, 3);
        options.motors.push_back(static_cast<std::size_t>(motor - 1));
    }
    return commissioning::checked_sweep_options(device, std::move(options));
}

void check_files(const TypedSweep &typed) {
    RunFiles files{
        {typed.board.device_file, typed.board.emulation.true_device_file, typed.tuning.file},
        {},
        {typed.csv}};
    if (!typed.svg.empty()) {
        if (typed.svg.extension() != ".svg") {
            throw InputError("--svg " + typed.svg.string() + ": must be a file that ends in .svg");
        }
        files.written.push_back(typed.svg);
        files.written.push_back(numbers_of(typed.svg));
    }
    check_outputs(files, typed.existing);
}

/// Until its end, or that of the program.
void run_to_end(StiffnessSweep &sweep) {
    ProgressLine line;
    std::string said;
    while (sweep.step()) {
        if (asked_to_end()) {
            sweep.stop();
            return;
        }
        if (sweep.stage() == SweepStage::measuring) {
            line.show(sweep.instruction(), sweep.share());
        } else {
            instruct(sweep.instruction(), "", said);
        }
    }
}

void judge(const TypedSweep &typed, const SweepReport &report) {
    const double share = 0.01 * *typed.tolerance;
    const double phase_rad = *typed.tolerance * kRadiansPerDegree;
    if (!report.is_certain()) {
        throw InputError("not everything was measured well enough to be judged; see the points "
                         "with a question mark");
    }
    if (!report.is_within(share, phase_rad)) {
        throw InputError(fmt::format("K_θ differs from the sampled form by more than {0:g} % or "
                                     "{0:g} degrees",
                                     *typed.tolerance));
    }
}

void sweep_device(const TypedSweep &typed) {
    check_files(typed);
    // Before a device is asked, as far as its file tells.
    static_cast<void>(checked_options(typed, device::read_device_file(typed.board.device_file)));
    const double period_s = servo::servo_period_s(typed.options.servo_hz);
    if (device_named(typed.board.device).kind == factory::DeviceKind::usb) {
        for (const std::string &warning : servo::make_this_thread_real_time(std::nullopt)) {
            print(std::cerr, "springdrive: remark: {}\n", warning);
        }
    }
    factory::BoardRequest request = typed.board.request();
    request.period_s = period_s;
    request.watchdog_periods = 5.0; // as for a servo
    const factory::OpenBoard board = open_to_drive(request, typed.board);
    const SweepOptions options = checked_options(typed, board.device->description());
    if (!board.device->is_zeroed()) {
        throw InputError("the device is not zeroed, so its angles are not known; hold it in its "
                         "zero pose, and add --at-zero");
    }
    note_ending_signals();
    StiffnessSweep sweep(*board.device, options);
    run_to_end(sweep);
    const SweepReport report = sweep.report();
    for (const std::string &warning : report.warnings) {
        print(std::cerr, "springdrive: remark: {}\n", warning);
    }
    if (!report.motors.empty() && (typed.csv != "-" || !report.is_complete)) {
        write_sweep_table(std::cout, board.device->description(), options, report);
    }
    if (!report.problem.empty()) {
        throw InputError(report.problem);
    }
    if (!report.is_complete) {
        print(std::cout, "not completed\n");
        end_with_status(1);
    }
    if (!typed.csv.empty()) {
        write_output(
            typed.csv, [&](std::ostream &out) { write_csv(out, sweep_table(report)); },
            typed.existing);
    }
    if (!typed.svg.empty()) {
        const device::DeviceIdentity identity = board.device->identity();
        draw_sweep(typed.svg, board.device->description().name + " " + identity.serial, options,
                   report, typed.existing);
    }
    if (typed.tolerance) {
        judge(typed, report);
    }
}

void add_frequency_options(Command &command, TypedSweep &typed) {
    add_servo_hz_option(command, typed.options.servo_hz);
    command.add_option("--freq-from", typed.options.min_hz, "lowest frequency [1]").type_name("HZ");
    command
        .add_option("--freq-to", typed.options.max_hz,
                    "highest frequency, up to a quarter of the servo rate [a tenth]")
        .type_name("HZ");
    command
        .add_option("--points", typed.options.points,
                    "number of frequencies, logarithmically spaced [12]")
        .type_name("N");
    command.add_option("--motors", typed.motors, "which ones [1,2,3]")
        .type_name("N,...")
        .delimiter(',');
}

void add_limit_options(Command &command, TypedSweep &typed) {
    command
        .add_option("--tip-force", typed.options.tip_force_N,
                    "limit of the force at the tip; the excitation itself stays below a third of "
                    "it [4]")
        .type_name("N");
    command.add_option("--motion", typed.options.motion_m, "largest amplitude of the tip [0.001]")
        .type_name("M");
    command.add_flag_callback(
        "--without-observer", [&typed] { typed.options.observes_resistance = false; },
        "R is taken from the device file, not observed: dR then differs from what was "
        "asked for as much as R does");
    command
        .add_option("--tolerance", typed.tolerance,
                    "exit status 1 unless every magnitude is within X % of the sampled form, and "
                    "every phase within X degrees [none]")
        .type_name("X");
}

} // namespace

void add_sweep(Command &device) {
    Command command = device.add_subcommand(
        "sweep",
        "the stiffness that the device renders, by a sine sweep of each motor, beside (12) "
        "and the sampled form with the measured d");
    const auto typed = std::make_shared<TypedSweep>();
    typed->board.add_to(command);
    typed->board.add_at_zero_to(command, "a board on USB must be zeroed");
    typed->tuning.add_to(command, TuningScope::coupling);
    add_frequency_options(command, *typed);
    add_limit_options(command, *typed);
    add_output_option(command, "--csv", typed->csv, "CSV");
    command.add_option("--svg", typed->svg, "a chart; its numbers are written beside it, as .csv")
        .type_name("FILE.svg");
    add_force_option(command, typed->existing);
    command.footer("The motors hold the tip where it is at the start, and shake it by less than a "
                   "millimetre. Keep a relaxed hand on it. Ctrl+C brakes.\n"
                   "Phases are those of -τ/θ: a spring has 0°, a damper +90°.\n"
                   "Exit status: 0 measured, 1 not completed or beyond --tolerance.");
    command.callback([typed] { sweep_device(*typed); });
}

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
        gadget.run([&] { return ends() || board.unplug_requested(); });
        gadget.unplug();
        print(std::cout, "{} is unplugged at {:.3f} s\n", typed.serial, board.time_s());
        std::cout.flush();
        gadget.run([&] { return ends() || !board.unplug_requested(); });
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
