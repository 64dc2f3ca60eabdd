#include "app/commands/commissioning_commands.h"

#include "app/commands/output_files.h"
#include "app/host/folders.h"
#include "app/host/process.h"
#include "base/degrees.h"
#include "base/input_error.h"
#include "base/print.h"
#include "base/text.h"
#include "device/core/device_file.h"
#include "device/core/motor/winding_heat.h"
#include "device/simulated/hand_tours.h"
#include "engine/commissioning/calibration_run.h"
#include "engine/commissioning/self_test.h"
#include "engine/session/windings_file.h"

#include <fmt/format.h>
#include <poll.h>

#include <array>
#include <cmath>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unistd.h>
#include <utility>

namespace springdrive::app {

namespace {

using commissioning::SelfTest;
using commissioning::SelfTestReport;
using commissioning::SelfTestStage;

constexpr int kFoundSomething = 1;

void show_info(const TypedBoard &typed) {
    factory::BoardRequest request = typed.request();
    request.ignores_calibration = true;
    const factory::OpenBoard board = factory::open_board(request);
    for (const device::Fact &fact : board.device->bench()->facts()) {
        print(std::cout, "{:<26}{}\n", fact.name, one_line(fact.value));
    }
}

struct TypedSelfTest {
    TypedBoard board;
    commissioning::SelfTestOptions options;
};

/// In the motion: it ends by Enter, or by a second one if the device was not everywhere.
class Person {
public:
    explicit Person(SelfTest &test) : test_(test) {}

    void follow() {
        const bool has_typed = has_typed_line();
        if (!std::exchange(has_begun_, true) || !has_typed) { // typed before it is no answer
            return;
        }
        if (test_.has_reached_all() || std::exchange(has_been_asked_, true)) {
            test_.finish_motion();
            return;
        }
        print(std::cerr, "not everywhere yet: {}; Enter again ends it all the same\n",
              test_.instruction());
    }

private:
    SelfTest &test_;
    bool has_begun_ = false;
    bool has_been_asked_ = false;
};

void show_windings(const SelfTestReport &report) {
    if (report.pulses.empty()) {
        return;
    }
    Table table = Table::with_columns("motor,R [Ohm],V_b [mV],L [mH]");
    if (report.has_motion) {
        table.columns.push_back({"counted/turned", ".3f"});
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const commissioning::WindingFigures &motor = report.windings.motor[i];
        table.rows.push_back(
            {i + 1, with_deviation(4, motor.resistance_Ohm, motor.resistance_deviation_Ohm),
             with_deviation(1, 1e3 * motor.brush_V, 1e3 * motor.brush_deviation_V),
             with_deviation(4, 1e3 * motor.inductance_H, 1e3 * motor.inductance_deviation_H)});
        if (report.has_motion) {
            table.rows.back().emplace_back(report.motion.motor[i].counts_per_turned);
        }
    }
    write_text(std::cout, table);
}

void show_stops(const SelfTestReport &report) {
    if (!report.has_motion) {
        return;
    }
    for (const commissioning::StopFigures &stop : report.motion.stops) {
        print(std::cout, "{}: moved from {:.1f} to {:.1f} degrees; its stop{} {:.1f}", stop.name,
              stop.lowest_rad / kRadiansPerDegree, stop.highest_rad / kRadiansPerDegree,
              stop.has_highest ? "s are at" : " is at", stop.file_lowest_rad / kRadiansPerDegree);
        if (stop.has_highest) {
            print(std::cout, " and {:.1f}", stop.file_highest_rad / kRadiansPerDegree);
        }
        print(std::cout, "\n");
    }
}

/// @return the command's exit status
int show(const SelfTestReport &report, bool is_zeroed) {
    show_windings(report);
    show_stops(report);
    for (const commissioning::Finding &finding : report.findings) {
        print(std::cout, "FOUND  {}\n       -> {}\n", finding.what, finding.remedy);
    }
    if (!report.is_complete) {
        print(std::cout, "not completed\n");
        return kFoundSomething;
    }
    if (!report.findings.empty()) {
        return kFoundSomething;
    }
    print(std::cout, "passed{}\n",
          !report.has_motion ? " the pulses; encoders, stops and zero were not checked"
          : is_zeroed        ? ""
                             : "; not zeroed, so the zero was not checked (--at-zero)");
    return 0;
}

void self_test(const TypedSelfTest &typed) {
    const factory::OpenBoard board = open_to_drive(typed.board.request(), typed.board);
    note_ending_signals();
    SelfTest test(*board.device, typed.options,
                  simulated::stop_tour_of(board.emulated ? &board.emulated->phantom() : nullptr,
                                          board.device->description()));
    Person person(test);
    std::string said;
    while (!asked_to_end() && test.step()) {
        const bool asks = test.stage() == SelfTestStage::motion && !board.emulated;
        if (asks) {
            person.follow();
        }
        instruct(test.instruction(), asks ? " (Enter when it was everywhere)" : "", said);
    }
    if (const int status = show(test.report(), board.device->is_zeroed()); status != 0) {
        end_with_status(status);
    }
}

} // namespace

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

void TypedBoard::add_at_zero_to(Command &command, const std::string &needed) {
    command.add_flag("--at-zero", is_at_zero,
                     "the device is held in its zero pose at the start: upper arm level, forearm "
                     "hanging, tip at the origin; " +
                         needed);
}

factory::OpenBoard open_to_drive(const factory::BoardRequest &request, const TypedBoard &typed) {
    factory::OpenBoard board = factory::open_board(request);
    if (!board.emulated) {
        static_cast<void>(session::take_windings(windings_folder(), board.device->identity().serial,
                                                 board.device->description().motor,
                                                 session::storing_time()));
    }
    if (board.emulated || typed.is_at_zero) {
        board.device->zero(Vector3::Zero());
    }
    return board;
}

bool has_typed_line() {
    bool has_end = false;
    for (pollfd input{0, POLLIN, 0}; poll(&input, 1, 0) > 0 && (input.revents & POLLIN) != 0;) {
        std::array<char, 256> typed{};
        const ssize_t size = read(0, typed.data(), typed.size());
        if (size <= 0) {
            break;
        }
        has_end =
            has_end || std::string_view(typed.data(), static_cast<std::size_t>(size)).find('\n') !=
                           std::string_view::npos;
    }
    return has_end;
}

void instruct(const std::string &instruction, const char *hint, std::string &said) {
    if (instruction != said && !instruction.empty()) {
        print(std::cerr, "{}{}\n", instruction, hint);
        said = instruction;
    }
}

Cell with_deviation(int digits, double value, double deviation) {
    return Cell::like_number(fmt::format("{:.{}f} +- {:.{}f}", value, digits, deviation, digits));
}

void add_info(Command &device) {
    Command command = device.add_subcommand(
        "info", "what a board says of itself: identity, limits, state, counters");
    const auto typed = std::make_shared<TypedBoard>();
    typed->add_to(command);
    command.callback([typed] { show_info(*typed); });
}

void add_self_test(Command &device) {
    Command command = device.add_subcommand(
        "self-test", "pulses on each winding, then motion by hand from stop to stop: names what is "
                     "wrong; exit status 1 if something is");
    const auto typed = std::make_shared<TypedSelfTest>();
    typed->options.lets_go_on = true;
    typed->board.add_to(command);
    typed->board.add_at_zero_to(command, "without it, the zero is not checked");
    command
        .add_option("--volts", typed->options.pulse.voltage_V,
                    "of the highest pulses, 0.3 to 2 [1.8]")
        .type_name("V");
    command.add_flag_callback(
        "--pulses-only", [typed] { typed->options.has_motion = false; },
        "without motion by hand, as for motors that are not on a linkage yet");
    command
        .add_option("--motion-seconds", typed->options.longest_motion_s,
                    "at most, for moving the device by hand [90]")
        .type_name("S");
    command.footer("No motor is driven but for pulses of some milliseconds, whose limits are the "
                   "board's own. The device brakes meanwhile, so it resists like a damper.");
    command.callback([typed] {
        check_range("--volts", typed->options.pulse.voltage_V, 0.3, 2.0);
        check_range("--motion-seconds", typed->options.longest_motion_s, 1.0, 3600.0);
        self_test(*typed);
    });
}

namespace {

using commissioning::CalibrationReport;
using commissioning::CalibrationRun;
using commissioning::CalibrationStage;
using commissioning::Cancellable;

constexpr int kNotCalibrated = 1;

struct TypedCalibration {
    TypedBoard board;
    bool is_to_board = false;
    std::filesystem::path out;
    Existing existing = Existing::keep;
    commissioning::CalibrationOptions options;
};

std::string text_of_file(const std::filesystem::path &file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

void show_numbers(const device::Calibration &calibration) {
    Table table = Table::with_columns(
        "motor,R [Ohm],V_b [mV],i_b [mA],ripple [Ohm],k_T [mN.m/A],offset [mA]");
    for (const device::MotorCalibration &motor : calibration.motor) {
        table.rows.push_back(
            {table.rows.size() + 1,
             with_deviation(4, motor.resistance_Ohm, motor.resistance_deviation_Ohm),
             with_deviation(1, 1e3 * motor.brush_voltage_V, 1e3 * motor.brush_deviation_V),
             Cell::like_number(fmt::format("{:.0f} to {:.0f}", 1e3 * motor.min_brush_current_A,
                                           1e3 * motor.max_brush_current_A)),
             Cell::like_number(fmt::format(
                 "{:.4f} at {:.0f} deg, {:.4f} (2nd)",
                 std::hypot(motor.ripple_cos_Ohm, motor.ripple_sin_Ohm),
                 std::atan2(motor.ripple_sin_Ohm, motor.ripple_cos_Ohm) / kRadiansPerDegree,
                 std::hypot(motor.ripple_cos_2_Ohm, motor.ripple_sin_2_Ohm))),
             with_deviation(3, 1e3 * motor.torque_constant_Nm_per_A,
                            1e3 * motor.torque_constant_deviation_Nm_per_A),
             with_deviation(2, 1e3 * motor.offset_A, 1e3 * motor.offset_deviation_A)});
    }
    write_text(std::cout, table);
}

/// What the numbers do not say.
void show_limits(const device::DeviceDescription &device, const device::Calibration &calibration) {
    const double air_share = device.motor.front().resistance_rise_per_K * calibration.air_error_K;
    print(
        std::cout,
        "R is at 25 degrees. The air's temperature, {:.3g} +- {:.3g} degrees, makes it uncertain "
        "by another {:.1f} %{}.\n"
        "A current sensor's gain, up to {:.0f} % off, scales R and R-hat alike: nothing here tells "
        "it, and it costs as much of dR.\n",
        calibration.air_C, calibration.air_error_K, 100.0 * air_share,
        calibration.air_error_K > commissioning::kThermometer_K ? "; --air-C makes it less" : "",
        100.0 * device.current_sensing.gain_tolerance);
}

void show_dR(const CalibrationReport &report, double dR_Ohm) {
    print(std::cout,
          "R-hat for a dR of {:.3g} Ohm, and the least dR that is permitted, with 3 "
          "deviations [Ohm]\n",
          dR_Ohm);
    Table table = Table::with_columns("motor,by the file,at a start,after a touch");
    for (const commissioning::MotorCalibrationReport &motor : report.motor) {
        table.rows.push_back({table.rows.size() + 1});
        for (const Cancellable &known : {motor.before, motor.at_start, motor.now}) {
            table.rows.back().push_back(Cell::like_number(
                fmt::format("{:.3f}, {:.3f}", known.R_hat_Ohm, known.min_dR_Ohm)));
        }
    }
    write_text(std::cout, table);
}

/// What the observers' picture of the last period depends on: d of the last commands, and what is
/// missing since the connection.
void show_link(const device::HapticDevice &device) {
    if (const std::optional<device::LinkStatus> link = device.link()) {
        print(std::cout,
              "the last commands acted after {:.2f} periods, at most {:.2f}; {} reports, {} lost, "
              "{} ticks without one\n",
              link->delay_s * CalibrationRun::kRate_hz,
              link->longest_delay_s * CalibrationRun::kRate_hz, link->reports, link->lost,
              link->absent);
    }
}

/// Runs it to its end, or to a signal. A person ends the motion by Enter.
void carry_out(CalibrationRun &run, bool is_by_person) {
    note_ending_signals();
    ProgressLine line;
    std::string said;
    bool has_begun = false;
    constexpr int kTicksBetweenLooks = 200;
    for (int tick = 0; !asked_to_end() && run.step(); ++tick) {
        const bool is_motion = run.stage() == CalibrationStage::motion;
        if (is_motion && is_by_person) {
            const bool has_typed = has_typed_line();
            if (std::exchange(has_begun, true) && has_typed) { // typed before it is no answer
                run.finish();
            }
        }
        if (tick % kTicksBetweenLooks != 0) {
            continue;
        }
        instruct(run.instruction(),
                 is_motion && is_by_person ? " (Enter ends it before all is known)" : "", said);
        if (is_motion) {
            line.show("calibrating", run.share());
        }
    }
}

void calibrate(const TypedCalibration &typed) {
    if (!typed.out.empty()) {
        check_outputs({{}, {}, {typed.out}}, typed.existing);
    }
    const std::string text = text_of_file(typed.board.device_file);
    factory::BoardRequest request = typed.board.request();
    request.ignores_calibration = true;
    request.watchdog_periods = 20.0; // this thread has no priority
    const factory::OpenBoard board = open_to_drive(request, typed.board);
    if (!board.emulated && !typed.board.is_at_zero) {
        throw InputError("hold the device in its zero pose, upper arm level, forearm hanging, tip "
                         "at the origin, and add --at-zero: its motors must know where it is");
    }
    CalibrationRun run(
        *board.device, typed.options,
        simulated::calibration_tour_of(board.emulated ? &board.emulated->phantom() : nullptr,
                                       board.device->description()));
    carry_out(run, !board.emulated);
    const CalibrationReport report = run.report();
    if (!report.is_complete) {
        print(std::cout, "not calibrated: {}\n", report.problem);
        show_link(*board.device);
        end_with_status(kNotCalibrated);
    }
    const device::DeviceDescription &device = board.device->description();
    print(std::cout, "{} '{}', {}, {:.0f} s of motion\n", device.name, report.calibration.serial,
          device::text_of_utc(report.calibration.made_at_s), report.motion_s);
    show_numbers(report.calibration);
    show_limits(device, report.calibration);
    show_link(*board.device);
    show_dR(report, typed.options.dR_Ohm);
    if (!typed.out.empty()) {
        const std::string calibrated = device::with_calibration(text, report.calibration);
        static_cast<void>(device::read_device_text(calibrated, typed.out)); // as it will be read
        write_output(
            typed.out.string(), [&](std::ostream &out) { out << calibrated; }, typed.existing);
        print(std::cout, "saved as {}: use it by --device-file\n", typed.out.string());
    }
    if (typed.is_to_board) {
        board.device->bench()->store(report.calibration);
        print(std::cout, "stored on the board, which every start asks for it\n");
    }
    if (typed.out.empty() && !typed.is_to_board) {
        print(std::cout, "not saved: --out FILE or --to-board keeps it\n");
    }
}

} // namespace

void add_calibrate(Command &device) {
    Command command = device.add_subcommand(
        "calibrate", "measures R of each winding with the commutator's ripple, k_T and the current "
                     "sensors' offsets, while the device is moved by hand; keeps them in a device "
                     "file or on the board");
    const auto typed = std::make_shared<TypedCalibration>();
    typed->options.lets_go_on = true;
    typed->board.add_to(command);
    typed->board.add_at_zero_to(command, "needed on USB");
    command
        .add_option("--out", typed->out,
                    "a device file to write: the one that --device-file names, with the "
                    "calibration")
        .type_name("FILE.toml");
    add_force_option(command, typed->existing);
    command.add_flag("--to-board", typed->is_to_board,
                     "keep it on the board, which has room for one");
    command
        .add_option("--air-C", typed->options.air_C,
                    "temperature of the air by a thermometer [unknown, 15 to 35]")
        .type_name("C");
    command
        .add_option("--dR", typed->options.dR_Ohm,
                    "residual resistance (7) while it moves, and for which R-hat is reported [0.5]")
        .type_name("Ω");
    command
        .add_option("--motion-seconds", typed->options.longest_motion_s,
                    "at most, for moving the device by hand [180]")
        .type_name("S");
    command.footer("The motors resist the hand like friction, each by up to 1.5 N at the tip, and "
                   "follow it otherwise. Ctrl+C ends it at any time.");
    command.callback([typed] {
        check_range("--dR", typed->options.dR_Ohm, 0.2, 2.0);
        check_range("--motion-seconds", typed->options.longest_motion_s, 1.0, 3600.0);
        if (typed->options.air_C) {
            check_range("--air-C", *typed->options.air_C, -20.0, 60.0);
        }
        calibrate(*typed);
    });
}

} // namespace springdrive::app
