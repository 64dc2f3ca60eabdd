#include "base/bisection.h"
#include "base/eigenvalues.h"
#include "device/core/phantom/kinematics.h"
#include "engine/lab/limits/method_limits/limit_trials.h"
#include "engine/lab/limits/thermal_hold.h"
#include "engine/servo/safety_monitor.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace springdrive::limits {

namespace {

/// The upper estimate of the temperatures T = (winding, housing) above the warmest air, under a
/// constant current: dT/dt = A T + h, whose heat i² R(T) at the commutator's worst angle grows with
/// T.
struct Warming {
    Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
    Eigen::Vector2d h = Eigen::Vector2d::Zero();

    /// @param tolerance  of R, as a share
    Warming(const device::MotorParameters &motor, double tolerance, double current_A) {
        const device::ThermalParameters &t = motor.thermal;
        const double winding_J_per_K = t.winding_time_s / t.winding_housing_K_per_W;
        const double housing_J_per_K = t.motor_time_s / t.housing_ambient_K_per_W;
        const double inner = 1.0 / t.winding_housing_K_per_W;
        const double outer = 1.0 / t.housing_ambient_K_per_W;
        const double cold_W = current_A * current_A * (1.0 + tolerance) * motor.resistance_Ohm *
                              (1.0 + motor.commutation_ripple);
        const double rise = motor.resistance_rise_per_K;
        A << (cold_W * rise - inner) / winding_J_per_K, inner / winding_J_per_K, //
            inner / housing_J_per_K, -(inner + outer) / housing_J_per_K;
        h[0] = cold_W * (1.0 + rise * (device::kWarmestAir_C - device::kReferenceTemperature_C)) /
               winding_J_per_K;
    }

    /// The winding's temperature, by the two modes of A.
    [[nodiscard]] double winding_C(double time_s) const {
        const Eigen::Vector2d rest = A.inverse() * h; // T = (e^(At) − 1) A⁻¹ h
        const Modes modes = real_modes(A);
        const Eigen::Matrix2d V = modes.eigenvectors;
        const Eigen::Vector2d share = V.inverse() * rest;
        const Eigen::Vector2d values = modes.eigenvalues;
        return device::kWarmestAir_C + V(0, 0) * share[0] * std::expm1(values[0] * time_s) +
               V(0, 1) * share[1] * std::expm1(values[1] * time_s);
    }
};

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

LimitTrial hot_after(const device::DeviceDescription &device) {
    constexpr double kCurrent_A = 3.0;
    constexpr double kPeriod_s = 1e-3;
    constexpr double kMax_s = 600.0;
    const device::MotorParameters &motor = device.motor[1];
    const Warming warming(motor, device.resistance_tolerance(1), kCurrent_A);
    LimitTrial trial;
    trial.line = {kMotorMethod,
                  "held for longer than",
                  "s",
                  with_unit(kCurrent_A, "A") + ": winding at " +
                      with_unit(motor.thermal.max_winding_C, "°C") + " by the upper estimate",
                  last_that_holds({0.0, kMax_s}, kLimitResolution,
                                  [&](double time_s) {
                                      return warming.winding_C(time_s) <
                                             motor.thermal.max_winding_C;
                                  }),
                  {},
                  {}};
    trial.reading = [=] { return trips_after_s(device, kCurrent_A, kPeriod_s, kMax_s); };
    return trial;
}

/// The continuous current warms the winding by (R_wh + R_ha) i² R(T).
LimitTrial hot_in_the_end(const device::DeviceDescription &device) {
    constexpr double kPeriod_s = 1.0; // under a tenth of the winding's time constant of 12 s
    constexpr double kMax_s = 20'000.0;
    const device::MotorParameters &motor = device.motor[1];
    const device::ThermalParameters &t = motor.thermal;
    const double rise_K = t.max_winding_C - device::kWarmestAir_C;
    const double hot_Ohm =
        (1.0 + device.resistance_tolerance(1)) * motor.resistance_Ohm *
        (1.0 + motor.commutation_ripple) *
        (1.0 + motor.resistance_rise_per_K * (t.max_winding_C - device::kReferenceTemperature_C));
    return {
        {kMotorMethod,
         "continuous current above",
         "A",
         "winding at " + with_unit(t.max_winding_C, "°C") + " by the upper estimate",
         std::sqrt(rise_K / ((t.winding_housing_K_per_W + t.housing_ambient_K_per_W) * hot_Ohm)),
         {},
         {}},
        0.01,
        motor.peak_current_A,
        false,
        [=](double current_A) { return !trips_after_s(device, current_A, kPeriod_s, kMax_s); }};
}

/// The share of K_DC (13) that remains after e_W has been applied for a time: the current (11)
/// falls as R rises, and with it the heat. Winding and housing are integrated by Runge-Kutta 4,
/// from the temperature at which R is specified.
/// @param ripple  R at the commutator's angle divided by R; 1 without ripple
double stiffness_left(const device::MotorParameters &motor, double current_A, double dR_Ohm,
                      double ripple, double time_s) {
    constexpr int kSteps = 200; // 0.3 s each in a minute, against the winding's 12 s: 10⁻⁸
    const device::ThermalParameters &t = motor.thermal;
    const auto warmed_Ohm = [&](const Eigen::Vector2d &rise_K) {
        return ripple * motor.resistance_Ohm * motor.resistance_rise_per_K * rise_K[0];
    };
    const auto rate_K_per_s = [&](const Eigen::Vector2d &rise_K) -> Eigen::Vector2d {
        const double now_A = current_A * dR_Ohm / (dR_Ohm + warmed_Ohm(rise_K));
        const double heat_W = (ripple * motor.resistance_Ohm + warmed_Ohm(rise_K)) * now_A * now_A;
        const double passed_W = (rise_K[0] - rise_K[1]) / t.winding_housing_K_per_W;
        return {(heat_W - passed_W) * t.winding_housing_K_per_W / t.winding_time_s,
                (passed_W - rise_K[1] / t.housing_ambient_K_per_W) * t.housing_ambient_K_per_W /
                    t.motor_time_s};
    };
    Eigen::Vector2d rise_K = Eigen::Vector2d::Zero();
    const double h_s = time_s / kSteps;
    for (int step = 0; step < kSteps; ++step) {
        const Eigen::Vector2d k1 = rate_K_per_s(rise_K);
        const Eigen::Vector2d k2 = rate_K_per_s(rise_K + 0.5 * h_s * k1);
        const Eigen::Vector2d k3 = rate_K_per_s(rise_K + 0.5 * h_s * k2);
        const Eigen::Vector2d k4 = rate_K_per_s(rise_K + h_s * k3);
        rise_K += h_s / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    return dR_Ohm / (dR_Ohm + warmed_Ohm(rise_K));
}

/// A held contact warms the windings: K_DC = k_T K_P/dR falls as R rises (7).
LimitTrial warm_contact(const device::DeviceDescription &device) {
    constexpr Eigen::Index kMotor = 1;
    ThermalHoldOptions options;
    options.force_N = 1.4;
    options.seconds = 60.0;
    const device::MotorParameters &motor = device.motor[kMotor];
    const Vector3 theta_rad = device::motor_from_joint(device.geometry, options.q_rad);
    // The motor's torque for that force along the normal.
    const double torque_Nm =
        options.force_N * device::motor_jacobian(device.geometry, options.q_rad)
                              .col(kMotor)
                              .dot(options.direction.normalized());
    const double ripple =
        1.0 + motor.commutation_ripple * std::cos(motor.commutator_segments * theta_rad[kMotor]);
    LimitTrial trial;
    trial.line = {"held contact",
                  "K_DC falls to",
                  "%",
                  "1.4 N for 60 s, dR " + with_unit(options.tuning.dR_Ohm, "Ω") + ", motor 2",
                  100.0 * stiffness_left(motor, torque_Nm / motor.torque_constant_Nm_per_A,
                                         options.tuning.dR_Ohm, ripple, options.seconds),
                  {},
                  {}};
    trial.reading = [=] {
        const std::vector<ThermalRow> rows = thermal_hold(device, options);
        const auto cooling = std::find_if(rows.begin(), rows.end(), [](const ThermalRow &row) {
            return row.phase == ThermalPhase::cool;
        });
        const ThermalRow &hot = *(cooling - 1);
        return std::optional(100.0 * hot.K_DC_Nm_per_rad[kMotor] /
                             rows.front().K_DC_Nm_per_rad[kMotor]);
    };
    return trial;
}

} // namespace

std::vector<LimitTrial> heat_trials(const device::DeviceDescription &device) {
    return {hot_after(device), hot_in_the_end(device), warm_contact(device)};
}

} // namespace springdrive::limits
