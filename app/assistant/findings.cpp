#include "app/assistant/step.h"

#include "device/core/haptic_device.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace springdrive::app::assistant {

namespace {

using commissioning::CalibrationProblem;
using commissioning::CalibrationReport;
using device::BoardFaults;
using servo::TripCause;

/// Half of an interval that has the value in 95 of 100 cases, in standard deviations.
constexpr double k95 = 1.96;

constexpr const char *kRemoveCause = "remove the cause";
constexpr const char *kLate = "a shorter cable, no hub; the doctor looks at this computer";

constexpr std::array<std::pair<std::uint16_t, const char *>, 10> kOfFaults{{
    {BoardFaults::kStop, "release the stop switch, and look whether the enable line is closed"},
    {BoardFaults::kAmplifier, "switch the board's supply off and on; if it comes again, a power "
                              "stage is damaged"},
    {BoardFaults::kSensor, "look at the plugs and the supply of the current sensors: one of them "
                           "measures nothing"},
    {BoardFaults::kSupply, "look at the supply and its leads: it must have the voltage that the "
                           "board is made for"},
    {BoardFaults::kTemperature, "let power stages and motors cool down, and look at the fan"},
    {BoardFaults::kHeat, "let the motors cool down for some minutes"},
    {BoardFaults::kOverCurrent, "look for a short circuit of a motor or its leads"},
    {BoardFaults::kEncoder, "look at the plugs and cables of the encoders"},
    {BoardFaults::kNoCommand, "commands came too late: a shorter cable, no hub; the doctor looks "
                              "at this computer"},
    {BoardFaults::kOverrun, "the board's firmware is too slow: install another one"},
}};

constexpr std::array<std::pair<TripCause, const char *>, 9> kOfCauses{{
    {TripCause::device_lost,
     "it was unplugged, or its board restarted: look at its cable and supply"},
    {TripCause::emergency_stop, "look whether all is well"},
    {TripCause::stale_measurement, kLate},
    {TripCause::missed_deadlines, kLate},
    {TripCause::motor_contradicted, "look at the plugs and cables of motors and encoders: one of "
                                    "them is dead, or another's"},
    {TripCause::tip_speed, "move the tip more slowly: a hand's breadth in a second or two"},
    {TripCause::beyond_stops, "keep the tip away from the stops, and look whether the zero pose "
                              "was right: go back to Zeroing"},
    {TripCause::window_silent, "the window stood still: close what keeps this computer busy"},
    {TripCause::assertion, "start the program again: nothing else resets this one"},
}};

std::string remedy_of_cause(TripCause cause) {
    const auto *const found =
        std::ranges::find(kOfCauses, cause, &std::pair<TripCause, const char *>::first);
    return found != kOfCauses.end() ? found->second : kRemoveCause;
}

} // namespace

std::string remedy_of(BoardFaults faults) {
    const auto *const found = std::ranges::find_if(
        kOfFaults, [&](const auto &remedy) { return faults.has(remedy.first); });
    return found != kOfFaults.end() ? found->second : kRemoveCause;
}

std::string remedy_of(const servo::SafetyStatus &stop) {
    return stop.cause == TripCause::board_fault
               ? remedy_of(BoardFaults{static_cast<std::uint16_t>(stop.measured)})
               : remedy_of_cause(stop.cause);
}

std::string unchecked_by(commissioning::Problem problem) {
    using commissioning::Problem;
    switch (problem) {
    case Problem::stops_not_reached:
        return "counts and zero were not checked by that stop";
    case Problem::wrong_inductance:
        return "L of the device file is not this motor's, so stability margins do not apply";
    case Problem::wrong_sensor_gain: // with a soft tuning's dR of 0.8 Ω, up to 50 % leave R̂ below R
        return "dR and the shown force of that channel are wrong by its sensor's gain";
    case Problem::board_fault:
    case Problem::wrong_voltage:
    case Problem::open_winding:
    case Problem::reversed_sensor:
    case Problem::crossed_sensors:
    case Problem::wrong_resistance:
    case Problem::seized_joint:
    case Problem::dead_encoder:
    case Problem::reversed_encoder:
    case Problem::crossed_encoders:
    case Problem::wrong_counts:
    case Problem::wrong_zero:
    case Problem::test_aborted:
        break;
    }
    return "";
}

void describe(const device::Calibration &calibration, const device::DeviceDescription &device,
              StepReport &report) {
    const auto beyond = [](double found, double of_file) {
        return 100.0 * (found / of_file - 1.0);
    };
    for (std::size_t j = 0; j < 3; ++j) {
        const device::MotorCalibration &motor = calibration.motor[j];
        const device::MotorParameters &file = device.motor[j];
        report.see("motor {}: R {:.4f} ± {:.4f} Ω ({:+.1f} % of the file's), brushes {:.1f} ± "
                   "{:.1f} mV, ripple {:.1f} %, k_T {:.3f} ± {:.3f} mN·m/A ({:+.1f} %), sensor "
                   "offset {:+.1f} mA",
                   j + 1, motor.resistance_Ohm, k95 * motor.resistance_deviation_Ohm,
                   beyond(motor.resistance_Ohm, file.resistance_Ohm), 1e3 * motor.brush_voltage_V,
                   1e3 * k95 * motor.brush_deviation_V,
                   100.0 * std::hypot(motor.ripple_cos_Ohm, motor.ripple_sin_Ohm) /
                       motor.resistance_Ohm,
                   1e3 * motor.torque_constant_Nm_per_A,
                   1e3 * k95 * motor.torque_constant_deviation_Nm_per_A,
                   beyond(motor.torque_constant_Nm_per_A, file.torque_constant_Nm_per_A),
                   1e3 * motor.offset_A);
        const double away = std::abs(motor.resistance_Ohm / file.resistance_Ohm - 1.0);
        if (away > file.resistance_tolerance) {
            report.seen.back() += fmt::format(". Such motors differ by {:.0f} %: the rest is the "
                                              "air's temperature, or its sensor's gain",
                                              100.0 * file.resistance_tolerance);
        }
    }
    report.see("± is for 95 of 100. Not found out: how warm the air is, {:.3g} ± {:.3g} °C, which "
               "is another {:.1f} % of R; and the current sensors' gains, up to {:.0f} %",
               calibration.air_C, calibration.air_error_K,
               100.0 * device.motor.front().resistance_rise_per_K * calibration.air_error_K,
               100.0 * device.current_sensing.gain_tolerance);
}

void describe_dR(const CalibrationReport &found, StepReport &report) {
    double before_Ohm = 0.0;
    double at_start_Ohm = 0.0;
    double now_Ohm = 0.0;
    for (const commissioning::MotorCalibrationReport &motor : found.motor) {
        before_Ohm = std::max(before_Ohm, motor.before.min_dR_Ohm);
        at_start_Ohm = std::max(at_start_Ohm, motor.at_start.min_dR_Ohm);
        now_Ohm = std::max(now_Ohm, motor.now.min_dR_Ohm);
    }
    report.see("least dR: {:.2f} Ω at a start, instead of {:.2f} Ω by the device file; {:.2f} Ω "
               "after a touch",
               at_start_Ohm, before_Ohm, now_Ohm);
}

void judge(const CalibrationReport &found, StepReport &report) {
    std::string remedy = "start again";
    report.verdict = Verdict::doubtful;
    switch (found.kind) {
    case CalibrationProblem::contradiction:
        report.verdict = Verdict::bad;
        remedy = "go back to Self-test";
        break;
    case CalibrationProblem::of_another_kind:
        report.verdict = Verdict::bad;
        remedy = "or look whether the right device file is used: its name is shown in Identity";
        break;
    case CalibrationProblem::stopped:
        if (const std::string of_cause = remedy_of_cause(found.trip); servo::is_final(found.trip)) {
            remedy = of_cause;
        } else if (of_cause == kRemoveCause && found.trip != TripCause::board_fault) {
            remedy += "; if it happens again, go back to Self-test";
        } else {
            remedy = of_cause + "; then start again";
        }
        break;
    case CalibrationProblem::little_motion:
        remedy += ", and move each bar to its end: all ways, without haste, until the step ends by "
                  "itself";
        break;
    case CalibrationProblem::never_at_rest:
    case CalibrationProblem::none:
    case CalibrationProblem::ended:
        break;
    }
    report.troubles.push_back({found.problem, remedy});
}

} // namespace springdrive::app::assistant
