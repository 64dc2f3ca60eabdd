// Motors and their amplifiers: resistance cancellation (6), voltage, current and heat.
#include "base/bisection.h"
#include "base/degrees.h"
#include "base/eigenvalues.h"
#include "device/core/motor/motor.h"
#include "device/core/motor/winding_heat.h"
#include "device/core/phantom/kinematics.h"
#include "engine/lab/limits/method_limits/experiment_list.h"
#include "engine/lab/limits/thermal_hold.h"
#include "engine/lab/rig/plant_equations.h"
#include "engine/servo/safety_monitor.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace springdrive::limits {

namespace {

using device::MotorParameters;

constexpr const char *kCancellationMethod = "resistance cancellation (6)";
constexpr double kSmall_A = 1e-3;

/// The current that is left of `start_A` behind the amplifier after that many steps, the rotor
/// turning at a constant rate.
double current_after_A(const MotorParameters &motor, device::DriveState now, double e_W_V,
                       double R_hat_Ohm, double step_s, int steps) {
    for (int i = 0; i < steps; ++i) {
        now.current_A = device::spring_drive_step(motor, now, e_W_V, R_hat_Ohm, step_s)
                            .end_at(now.rate_rad_per_s);
    }
    return now.current_A;
}

/// The remainder of a small current in a winding of that resistance, its rotor held.
double remainder_A(const MotorParameters &motor, double resistance_Ohm, double R_hat_Ohm,
                   double time_s) {
    constexpr int kSteps = 1000;
    return current_after_A(motor, {resistance_Ohm, kSmall_A, 0.0, true}, 0.0, R_hat_Ohm,
                           time_s / kSteps, kSteps);
}

bool decays(const MotorParameters &motor, double winding_C, double theta_rad, double R_hat_Ohm) {
    constexpr double kWatched_s = 0.1;
    return remainder_A(motor, device::winding_resistance_Ohm(motor, winding_C, theta_rad),
                       R_hat_Ohm, kWatched_s) < kSmall_A;
}

/// The angle at which R(T, θ) is smallest.
double worst_angle_rad(const MotorParameters &motor) {
    return std::numbers::pi / motor.commutator_segments;
}

Experiment cold_winding(MotorParameters motor) {
    constexpr double kNet_Ohm = 0.1;
    motor.commutation_ripple = 0.0;
    const double R_hat_Ohm = motor.resistance_Ohm - kNet_Ohm;
    return {{kCancellationMethod, "winding cooler than", "°C",
             "R̂ tuned for dR " + with_unit(kNet_Ohm, "Ω") + " at 25 °C, rotor held",
             device::kReferenceTemperature_C -
                 kNet_Ohm / (motor.resistance_rise_per_K * motor.resistance_Ohm)},
            {device::kReferenceTemperature_C, -40.0},
            [=](double winding_C) { return decays(motor, winding_C, 0.0, R_hat_Ohm); }};
}

/// R̂ is tuned at the middle of the commutator's ripple; then the rotor turns.
Experiment commutator(const MotorParameters &motor) {
    constexpr int kAngles = 64; // of one ripple
    return {{kCancellationMethod, "dR tuned below", "Ω",
             "at 25 °C, the worst of " + with_unit(kAngles, "angles of the commutator"),
             motor.commutation_ripple * motor.resistance_Ohm},
            {motor.resistance_Ohm, 1e-3},
            [=](double dR_Ohm) {
                for (int i = 0; i < kAngles; ++i) {
                    if (!decays(motor, device::kReferenceTemperature_C,
                                2.0 * i * worst_angle_rad(motor) / kAngles,
                                motor.resistance_Ohm - dR_Ohm)) {
                        return false;
                    }
                }
                return true;
            }};
}

/// e^(|dR|t/L).
Experiment growth(const MotorParameters &motor) {
    constexpr double kTooMuch_Ohm = 0.1;
    constexpr double kTime_s = 5e-3;
    return {.row = {kCancellationMethod, "current grows e-fold in", "ms",
                    "R̂ " + with_unit(kTooMuch_Ohm, "Ω") + " above R, rotor held",
                    1e3 * motor.inductance_H / kTooMuch_Ohm},
            .reading = [=] {
                const double end_A = remainder_A(motor, motor.resistance_Ohm,
                                                 motor.resistance_Ohm + kTooMuch_Ohm, kTime_s);
                return std::optional(1e3 * kTime_s / std::log(end_A / kSmall_A));
            }};
}

/// When all of R is requested, the guard allows R of a winding in the coldest air, less a reserve.
Experiment guarded(const device::DeviceDescription &device) {
    const MotorParameters &motor = device.motor[1];
    const double rise_per_K = motor.resistance_rise_per_K;
    const double coldest = 1.0 + rise_per_K * (device::kColdestAir_C -
                                               device::kReferenceTemperature_C); // of R at 25 °C
    const double R_hat_Ohm =
        device::WindingGuard(motor, device.amplifier.max_cancelled_Ohm, 1.0).max_cancelled_Ohm();
    return {{fmt::format("{}, guarded", kCancellationMethod), "winding cooler than", "°C",
             fmt::format("dR 0 requested, worst angle; the guard assumes air of {} or more",
                         with_unit(device::kColdestAir_C, "°C")),
             device::kReferenceTemperature_C +
                 ((1.0 - device::kMinResidualShare) * coldest - 1.0) / rise_per_K},
            {device::kReferenceTemperature_C, -40.0},
            [=](double winding_C) {
                return decays(motor, winding_C, worst_angle_rad(motor),
                              std::min(motor.resistance_Ohm, R_hat_Ohm));
            }};
}

/// Whether the simulated amplifier settles at the current of (11), i = (e_W − k_T θ̇)/dR.
bool settles(const MotorParameters &motor, double e_W_V, double rate_rad_per_s) {
    constexpr int kSteps = 2000;
    constexpr double kStep_s = 50e-6; // some 200 times L/dR in total
    constexpr double kOff_A = 1e-5;
    const double dR_Ohm = control::Tuning{}.dR_Ohm;
    const double settled_A =
        current_after_A(motor, {motor.resistance_Ohm, 0.0, rate_rad_per_s, true}, e_W_V,
                        motor.resistance_Ohm - dR_Ohm, kStep_s, kSteps);
    const double requested_A = (e_W_V - motor.torque_constant_Nm_per_A * rate_rad_per_s) / dR_Ohm;
    return std::abs(settled_A - requested_A) < kOff_A;
}

/// K_P (θ_Sd − θ)/dR reaches the peak current, or what the supply drives through R at standstill.
Experiment at_stall(const MotorParameters &motor) {
    const control::Tuning tuning;
    const double max_A = std::min(motor.peak_current_A, motor.supply_V / motor.resistance_Ohm);
    return {{kMotorMethod, "θ_Sd − θ above", "°",
             "tuning firm, rotor held: the amplifier is limited to " + with_unit(max_A, "A"),
             kDegreesPerRadian * max_A * tuning.dR_Ohm / tuning.K_P_V_per_rad},
            {1e-2, 1e3},
            [=](double error_deg) {
                return settles(motor, tuning.K_P_V_per_rad * error_deg / kDegreesPerRadian, 0.0);
            }};
}

/// e_A = R̂ i + e_W reaches the supply at i = (e_W − k_T θ̇)/dR: the faster a rotor returns to its
/// set-point, the more of the supply the back-EMF takes.
Experiment returning(const MotorParameters &motor) {
    constexpr double kRate_rad_per_s = 100.0;
    const control::Tuning tuning;
    const double back_emf_V = motor.torque_constant_Nm_per_A * kRate_rad_per_s;
    const double damping_V = tuning.K_D_Vs_per_rad * kRate_rad_per_s;
    const double R_hat_Ohm = motor.resistance_Ohm - tuning.dR_Ohm;
    const double e_W_V =
        (motor.supply_V * tuning.dR_Ohm + R_hat_Ohm * back_emf_V) / motor.resistance_Ohm;
    const double no_current_deg =
        kDegreesPerRadian * (back_emf_V + damping_V) / tuning.K_P_V_per_rad;
    return {{kMotorMethod, "θ_Sd − θ above", "°",
             "tuning firm, rotor returning at " + with_unit(kRate_rad_per_s, "rad/s") +
                 ": R̂ i + e_W reaches the supply of " + with_unit(motor.supply_V, "V"),
             kDegreesPerRadian * (e_W_V + damping_V) / tuning.K_P_V_per_rad},
            {no_current_deg, 1e3},
            [=](double error_deg) {
                const double pull_V = tuning.K_P_V_per_rad * error_deg / kDegreesPerRadian;
                return settles(motor, pull_V - damping_V, kRate_rad_per_s);
            }};
}

/// The upper estimate of the winding's temperature under a constant current. With the temperatures
/// T = (winding, housing) above the warmest air, dT/dt = A T + h, whose heat i² R(T) at the
/// commutator's worst angle grows with T.
/// @param tolerance  of R, as a share
double warmed_winding_C(const MotorParameters &motor, double tolerance, double current_A,
                        double time_s) {
    const device::ThermalParameters &t = motor.thermal;
    const double winding_J_per_K = t.winding_time_s / t.winding_housing_K_per_W;
    const double housing_J_per_K = t.motor_time_s / t.housing_ambient_K_per_W;
    const double inner = 1.0 / t.winding_housing_K_per_W;
    const double outer = 1.0 / t.housing_ambient_K_per_W;
    const double cold_W = current_A * current_A * (1.0 + tolerance) * motor.resistance_Ohm *
                          (1.0 + motor.commutation_ripple);
    const double rise = motor.resistance_rise_per_K;
    Eigen::Matrix2d A;
    A << (cold_W * rise - inner) / winding_J_per_K, inner / winding_J_per_K, //
        inner / housing_J_per_K, -(inner + outer) / housing_J_per_K;
    const double warm = 1.0 + rise * (device::kWarmestAir_C - device::kReferenceTemperature_C);
    const Eigen::Vector2d h(cold_W * warm / winding_J_per_K, 0.0);
    // T = (e^(At) − 1) A⁻¹ h, by the two modes of A.
    const Modes modes = real_modes(A);
    const Eigen::Matrix2d V = modes.eigenvectors;
    const Eigen::Vector2d share = V.inverse() * (A.inverse() * h);
    return device::kWarmestAir_C + V(0, 0) * share[0] * std::expm1(modes.eigenvalues[0] * time_s) +
           V(0, 1) * share[1] * std::expm1(modes.eigenvalues[1] * time_s);
}

/// The time after which the safety monitor stops a device with that current in one motor [s];
/// nothing where it does not within `longest_s`.
std::optional<double> trips_after_s(const device::DeviceDescription &device, double current_A,
                                    double period_s, double longest_s) {
    servo::SafetyMonitor monitor(device, period_s);
    servo::Observation seen;
    seen.motors = control::motors_of_file(device.motor);
    const Vector3 q_rad(0.0, 0.2, 0.1);
    seen.now.theta_rad = device::motor_from_joint(device.geometry, q_rad);
    seen.now.tip_m = device::tip_position_m(device.geometry, q_rad);
    seen.now.J = device::motor_jacobian(device.geometry, q_rad);
    seen.current_A[1] = current_A;
    for (long tick = 1; static_cast<double>(tick) * period_s < longest_s; ++tick) {
        static_cast<void>(monitor.pass(device::DeviceCommand::braking(), seen, {}));
        if (monitor.status().cause == servo::TripCause::winding_temperature) {
            return static_cast<double>(tick) * period_s;
        }
    }
    return std::nullopt;
}

Experiment hot_after(const device::DeviceDescription &device) {
    constexpr double kCurrent_A = 3.0;
    constexpr double kPeriod_s = 1e-3;
    constexpr double kMax_s = 600.0;
    const MotorParameters &motor = device.motor[1];
    const double max_C = motor.thermal.max_winding_C;
    const double predicted_s =
        last_that_holds({0.0, kMax_s}, TriedValues{}.resolution, [&](double time_s) {
            return warmed_winding_C(motor, device.resistance_tolerance(1), kCurrent_A, time_s) <
                   max_C;
        });
    return {.row = {kMotorMethod, "held for longer than", "s",
                    with_unit(kCurrent_A, "A") + ": winding at " + with_unit(max_C, "°C") +
                        " by the upper estimate",
                    predicted_s},
            .reading = [=] { return trips_after_s(device, kCurrent_A, kPeriod_s, kMax_s); }};
}

/// The continuous current warms the winding by (R_wh + R_ha) i² R(T).
Experiment hot_in_the_end(const device::DeviceDescription &device) {
    constexpr double kPeriod_s = 1.0; // under a tenth of the winding's time constant of 12 s
    constexpr double kMax_s = 20'000.0;
    const MotorParameters &motor = device.motor[1];
    const device::ThermalParameters &t = motor.thermal;
    const double rise_K = t.max_winding_C - device::kWarmestAir_C;
    const double hot_Ohm =
        (1.0 + device.resistance_tolerance(1)) * motor.resistance_Ohm *
        (1.0 + motor.commutation_ripple) *
        (1.0 + motor.resistance_rise_per_K * (t.max_winding_C - device::kReferenceTemperature_C));
    return {
        {kMotorMethod, "continuous current above", "A",
         "winding at " + with_unit(t.max_winding_C, "°C") + " by the upper estimate",
         std::sqrt(rise_K / ((t.winding_housing_K_per_W + t.housing_ambient_K_per_W) * hot_Ohm))},
        {0.01, motor.peak_current_A},
        [=](double current_A) { return !trips_after_s(device, current_A, kPeriod_s, kMax_s); }};
}

/// The share of K_DC (13) that remains after e_W has been applied for a time: the current (11)
/// falls as R rises, and with it the heat. Winding and housing warm from the temperature at which R
/// is specified.
/// @param ripple  R at the commutator's angle divided by R; 1 without ripple
double stiffness_left(const MotorParameters &motor, double current_A, double dR_Ohm, double ripple,
                      double time_s) {
    constexpr int kSteps = 200; // 0.3 s each in a minute, against the winding's 12 s: 10⁻⁸
    const device::ThermalParameters &t = motor.thermal;
    const auto warmed_Ohm = [&](const Eigen::Vector2d &rise_K) {
        return ripple * motor.resistance_Ohm * motor.resistance_rise_per_K * rise_K[0];
    };
    const auto rate_K_per_s = [&](double, const Eigen::Vector2d &rise_K) -> Eigen::Vector2d {
        const double now_A = current_A * dR_Ohm / (dR_Ohm + warmed_Ohm(rise_K));
        const double heat_W = (ripple * motor.resistance_Ohm + warmed_Ohm(rise_K)) * now_A * now_A;
        const double passed_W = (rise_K[0] - rise_K[1]) / t.winding_housing_K_per_W;
        return {(heat_W - passed_W) * t.winding_housing_K_per_W / t.winding_time_s,
                (passed_W - rise_K[1] / t.housing_ambient_K_per_W) * t.housing_ambient_K_per_W /
                    t.motor_time_s};
    };
    Eigen::Vector2d rise_K = Eigen::Vector2d::Zero();
    for (int step = 0; step < kSteps; ++step) {
        rise_K = rig::runge_kutta_step(rate_K_per_s, 0.0, rise_K, time_s / kSteps);
    }
    return dR_Ohm / (dR_Ohm + warmed_Ohm(rise_K));
}

/// A held contact warms the windings: K_DC = k_T K_P/dR falls as R rises (7).
Experiment warm_contact(const device::DeviceDescription &device) {
    constexpr Eigen::Index kMotor = 1;
    ThermalHoldOptions options;
    options.force_N = 1.4;
    options.seconds = 60.0;
    const MotorParameters &motor = device.motor[kMotor];
    const Vector3 theta_rad = device::motor_from_joint(device.geometry, options.q_rad);
    // The motor's torque for that force along the normal.
    const double torque_Nm =
        options.force_N * device::motor_jacobian(device.geometry, options.q_rad)
                              .col(kMotor)
                              .dot(options.direction.normalized());
    const double ripple =
        1.0 + motor.commutation_ripple * std::cos(motor.commutator_segments * theta_rad[kMotor]);
    return {.row = {"held contact", "K_DC falls to", "%",
                    "1.4 N for 60 s, dR " + with_unit(options.tuning.dR_Ohm, "Ω") + ", motor 2",
                    100.0 * stiffness_left(motor, torque_Nm / motor.torque_constant_Nm_per_A,
                                           options.tuning.dR_Ohm, ripple, options.seconds)},
            .reading = [=] {
                const std::vector<ThermalRow> rows = thermal_hold(device, options);
                const auto cooling =
                    std::ranges::find(rows, ThermalPhase::cool, &ThermalRow::phase);
                return std::optional(100.0 * (cooling - 1)->K_DC_Nm_per_rad[kMotor] /
                                     rows.front().K_DC_Nm_per_rad[kMotor]);
            }};
}

} // namespace

Experiments cancellation_experiments(const device::DeviceDescription &device) {
    const MotorParameters &motor = device.motor[1];
    return {cold_winding(motor), commutator(motor), growth(motor), guarded(device)};
}

Experiments amplifier_experiments(const device::DeviceDescription &device) {
    return {at_stall(device.motor[1]), returning(device.motor[1])};
}

Experiments heat_experiments(const device::DeviceDescription &device) {
    return {hot_after(device), hot_in_the_end(device), warm_contact(device)};
}

} // namespace springdrive::limits
