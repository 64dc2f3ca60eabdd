#include "app/commands/commissioning_commands.h"

#include "app/commands/output_files.h"
#include "app/commands/progress_line.h"
#include "app/host/ending_signal.h"
#include "base/degrees.h"
#include "base/input_error.h"
#include "base/print.h"
#include "device/core/calibration_file.h"
#include "device/core/device_file.h"
#include "device/core/motor/winding_guard.h"
#include "device/simulated/calibration_tour.h"
#include "engine/commissioning/calibration_run.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace springdrive::app {

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
    Table table = Table::with_columns("motor,R [Ohm],ripple [Ohm],k_T [mN.m/A],offset [mA]");
    for (const device::MotorCalibration &motor : calibration.motor) {
        table.rows.push_back(
            {table.rows.size() + 1,
             with_deviation(4, motor.resistance_Ohm, motor.resistance_deviation_Ohm),
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
    command.footer("The motors resist the hand gently, by some 0.5 N at the tip, and follow it "
                   "otherwise; they never push. Ctrl+C ends it at any time.");
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
