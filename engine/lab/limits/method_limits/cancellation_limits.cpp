#include "engine/lab/limits/method_limits/limit_trials.h"

#include "device/core/motor/amplifier.h"
#include "device/core/motor/winding_guard.h"
#include "device/core/motor/winding_temperature.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace springdrive::limits {

namespace {

constexpr const char *kCancellationMethod = "resistance cancellation (6)";
constexpr double kSmall_A = 1e-3;

/// The remainder of a small current in a winding of that resistance behind the amplifier.
double current_after_A(const device::MotorParameters &motor, double resistance_Ohm,
                       double R_hat_Ohm, double time_s) {
    constexpr int kSteps = 1000;
    device::DriveState now{resistance_Ohm, kSmall_A, 0.0, true};
    for (int i = 0; i < kSteps; ++i) {
        now.current_A =
            device::spring_drive_step(motor, now, 0.0, R_hat_Ohm, time_s / kSteps).end_at(0.0);
    }
    return now.current_A;
}

bool decays(const device::MotorParameters &motor, double resistance_Ohm, double R_hat_Ohm) {
    constexpr double kWatched_s = 0.1;
    return current_after_A(motor, resistance_Ohm, R_hat_Ohm, kWatched_s) < kSmall_A;
}

/// The angle at which R(T, θ) is smallest.
double worst_angle_rad(const device::MotorParameters &motor) {
    return std::numbers::pi / motor.commutator_segments;
}

LimitTrial cold_winding(device::MotorParameters motor) {
    constexpr double kNet_Ohm = 0.1;
    motor.commutation_ripple = 0.0;
    const double R_hat_Ohm = motor.resistance_Ohm - kNet_Ohm;
    return {{kCancellationMethod,
             "winding cooler than",
             "°C",
             "R̂ tuned for dR " + with_unit(kNet_Ohm, "Ω") + " at 25 °C, rotor held",
             device::kReferenceTemperature_C -
                 kNet_Ohm / (motor.resistance_rise_per_K * motor.resistance_Ohm),
             {},
             {}},
            device::kReferenceTemperature_C,
            -40.0,
            false,
            [=](double winding_C) {
                return decays(motor, device::winding_resistance_Ohm(motor, winding_C, 0.0),
                              R_hat_Ohm);
            }};
}

/// R̂ is tuned at the middle of the commutator's ripple; then the rotor turns.
LimitTrial commutator(const device::MotorParameters &motor) {
    constexpr int kAngles = 64; // of one ripple
    return {{kCancellationMethod,
             "dR tuned below",
             "Ω",
             "at 25 °C, the worst of " + with_unit(kAngles, "angles of the commutator"),
             motor.commutation_ripple * motor.resistance_Ohm,
             {},
             {}},
            motor.resistance_Ohm,
            1e-3,
            false,
            [=](double dR_Ohm) {
                for (int i = 0; i < kAngles; ++i) {
                    const double theta_rad = 2.0 * i * worst_angle_rad(motor) / kAngles;
                    if (!decays(motor,
                                device::winding_resistance_Ohm(
                                    motor, device::kReferenceTemperature_C, theta_rad),
                                motor.resistance_Ohm - dR_Ohm)) {
                        return false;
                    }
                }
                return true;
            }};
}

/// e^(|dR|t/L).
LimitTrial growth(const device::MotorParameters &motor) {
    constexpr double kTooMuch_Ohm = 0.1;
    constexpr double kTime_s = 5e-3;
    LimitTrial trial;
    trial.line = {kCancellationMethod,
                  "current grows e-fold in",
                  "ms",
                  "R̂ " + with_unit(kTooMuch_Ohm, "Ω") + " above R, rotor held",
                  1e3 * motor.inductance_H / kTooMuch_Ohm,
                  {},
                  {}};
    trial.reading = [=] {
        const double end_A = current_after_A(motor, motor.resistance_Ohm,
                                             motor.resistance_Ohm + kTooMuch_Ohm, kTime_s);
        return std::optional(1e3 * kTime_s / std::log(end_A / kSmall_A));
    };
    return trial;
}

/// When all of R is requested, the guard allows R of a winding in the coldest air, less a reserve.
LimitTrial guarded(const device::DeviceDescription &device) {
    const device::MotorParameters &motor = device.motor[1];
    const double rise_per_K = motor.resistance_rise_per_K;
    const double coldest = 1.0 + rise_per_K * (device::kColdestAir_C -
                                               device::kReferenceTemperature_C); // of R at 25 °C
    const double R_hat_Ohm =
        device::WindingGuard(motor, device.amplifier.max_cancelled_Ohm, 1.0).max_cancelled_Ohm();
    return {{fmt::format("{}, guarded", kCancellationMethod),
             "winding cooler than",
             "°C",
             fmt::format("dR 0 requested, worst angle; the guard assumes air of {} or more",
                         with_unit(device::kColdestAir_C, "°C")),
             device::kReferenceTemperature_C +
                 ((1.0 - device::kMinResidualShare) * coldest - 1.0) / rise_per_K,
             {},
             {}},
            device::kReferenceTemperature_C,
            -40.0,
            false,
            [=](double winding_C) {
                return decays(
                    motor, device::winding_resistance_Ohm(motor, winding_C, worst_angle_rad(motor)),
                    std::min(motor.resistance_Ohm, R_hat_Ohm));
            }};
}

} // namespace

std::vector<LimitTrial> cancellation_trials(const device::DeviceDescription &device) {
    const device::MotorParameters &motor = device.motor[1];
    return {cold_winding(motor), commutator(motor), growth(motor), guarded(device)};
}

} // namespace springdrive::limits
