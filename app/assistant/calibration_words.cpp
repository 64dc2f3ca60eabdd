#include "app/assistant/calibration_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace springdrive::app::assistant {

namespace {

using commissioning::CalibrationProblem;
using commissioning::CalibrationReport;

/// Half of an interval that has the value in 95 of 100 cases, in standard deviations.
constexpr double k95 = 1.96;

/// What makes a device stop, and what a hand can do about it.
std::string remedy_of_stop(servo::TripCause cause) {
    switch (cause) {
    case servo::TripCause::tip_speed:
        return "move the tip more slowly: a hand's breadth in a second or two";
    case servo::TripCause::beyond_stops:
        return "keep the tip away from the stops, and look whether the zero pose was right: go "
               "back to Zeroing";
    case servo::TripCause::stale_measurement:
    case servo::TripCause::missed_deadlines:
        return "the connection or the computer was late: go back to Connection, or ask the doctor";
    case servo::TripCause::window_silent:
        return "the window stood still; close what keeps this computer busy, then start again";
    case servo::TripCause::device_lost:
        return "plug the board in again, then start again";
    case servo::TripCause::board_fault:
        return "remove the cause, then start again";
    default:
        return "start again; if it happens again, go back to Self-test";
    }
}

} // namespace

std::vector<std::string> words_of(const device::Calibration &calibration,
                                  const device::DeviceDescription &device) {
    std::vector<std::string> words;
    for (std::size_t j = 0; j < 3; ++j) {
        const device::MotorCalibration &motor = calibration.motor[j];
        const device::MotorParameters &file = device.motor[j];
        const auto beyond = [](double found, double of_file) {
            return 100.0 * (found / of_file - 1.0);
        };
        words.push_back(fmt::format(
            "motor {}: R {:.4f} ± {:.4f} Ω ({:+.1f} % of the file's), ripple {:.1f} %, "
            "k_T {:.3f} ± {:.3f} mN·m/A ({:+.1f} %), sensor offset {:+.1f} mA",
            j + 1, motor.resistance_Ohm, k95 * motor.resistance_deviation_Ohm,
            beyond(motor.resistance_Ohm, file.resistance_Ohm),
            100.0 * std::hypot(motor.ripple_cos_Ohm, motor.ripple_sin_Ohm) / motor.resistance_Ohm,
            1e3 * motor.torque_constant_Nm_per_A,
            1e3 * k95 * motor.torque_constant_deviation_Nm_per_A,
            beyond(motor.torque_constant_Nm_per_A, file.torque_constant_Nm_per_A),
            1e3 * motor.offset_A));
        const double away = std::abs(motor.resistance_Ohm / file.resistance_Ohm - 1.0);
        if (away > file.resistance_tolerance) {
            words.back() += fmt::format(". Such motors differ by {:.0f} %: the rest is the air's "
                                        "temperature, or its sensor's gain",
                                        100.0 * file.resistance_tolerance);
        }
    }
    words.push_back(fmt::format(
        "± is for 95 of 100. Not found out: how warm the air is, {:.3g} ± {:.3g} °C, which is "
        "another {:.1f} % of R; and the current sensors' gains, up to {:.0f} %",
        calibration.air_C, calibration.air_error_K,
        100.0 * device.motor.front().resistance_rise_per_K * calibration.air_error_K,
        100.0 * device.current_sensing.gain_tolerance));
    return words;
}

std::string words_on_dR(const CalibrationReport &report) {
    double before_Ohm = 0.0;
    double at_start_Ohm = 0.0;
    double now_Ohm = 0.0;
    for (const commissioning::MotorCalibrationReport &motor : report.motor) {
        before_Ohm = std::max(before_Ohm, motor.before.least_dR_Ohm);
        at_start_Ohm = std::max(at_start_Ohm, motor.at_start.least_dR_Ohm);
        now_Ohm = std::max(now_Ohm, motor.now.least_dR_Ohm);
    }
    return fmt::format("least dR: {:.2f} Ω at a start, instead of {:.2f} Ω by the device file; "
                       "{:.2f} Ω after a touch",
                       at_start_Ohm, before_Ohm, now_Ohm);
}

Verdict verdict_on(CalibrationProblem problem) {
    switch (problem) {
    case CalibrationProblem::contradiction:
    case CalibrationProblem::of_another_kind:
        return Verdict::bad;
    case CalibrationProblem::none:
    case CalibrationProblem::ended:
    case CalibrationProblem::stopped:
    case CalibrationProblem::never_at_rest:
    case CalibrationProblem::little_motion:
        break;
    }
    return Verdict::doubtful;
}

Trouble trouble_of(const CalibrationReport &report) {
    switch (report.kind) {
    case CalibrationProblem::contradiction:
        return {report.problem, "go back to Self-test"};
    case CalibrationProblem::of_another_kind:
        return {report.problem, "or look whether the right device file is used: its name is shown "
                                "in Identity"};
    case CalibrationProblem::stopped:
        return {report.problem, remedy_of_stop(report.trip)};
    case CalibrationProblem::never_at_rest:
        return {report.problem, "start again"};
    case CalibrationProblem::little_motion:
        return {report.problem, "start again, and move each bar to its end: all ways, without "
                                "haste, until the step ends by itself"};
    case CalibrationProblem::none:
    case CalibrationProblem::ended:
        break;
    }
    return {report.problem, "start again"};
}

} // namespace springdrive::app::assistant
