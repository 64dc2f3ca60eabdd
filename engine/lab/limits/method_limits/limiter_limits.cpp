#include "base/degrees.h"
#include "device/core/motor/winding_guard.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/haptic_law.h"
#include "engine/lab/limits/method_limits/limit_trials.h"
#include "engine/servo/command_limiter.h"

#include <algorithm>
#include <cmath>

namespace springdrive::limits {

namespace {

/// The law's command at one configuration, passed through the limiter.
class LimitedLaw {
public:
    LimitedLaw(const device::DeviceDescription &device, const Vector3 &q_rad)
        : device_(device), law_(device),
          theta_rad_(device::motor_from_joint(device.geometry, q_rad)) {}

    /// Pressed in by `depth_m`, at rest.
    [[nodiscard]] servo::ActiveLimits pressed(double depth_m, const Vector3 &normal) const {
        const control::Configuration now = law_.configuration(theta_rad_, Vector3::Zero());
        contact::Contact contact;
        contact.touching = true;
        contact.eta = 0.0;
        contact.normal = normal;
        contact.x0_m = now.tip_m + depth_m * normal;
        contact.tangent_projector = Matrix3::Identity() - normal * normal.transpose();
        return active_limits(now, contact);
    }

    /// In free space, one motor turning.
    [[nodiscard]] servo::ActiveLimits turning(double rate_rad_per_s) const {
        const control::Configuration now =
            law_.configuration(theta_rad_, Vector3(0.0, rate_rad_per_s, 0.0));
        contact::Contact contact;
        contact.x0_m = now.tip_m;
        return active_limits(now, contact);
    }

private:
    [[nodiscard]] servo::ActiveLimits active_limits(const control::Configuration &now,
                                                    const contact::Contact &contact) const {
        servo::LimiterInputs inputs{now, servo::limits_of(device_), 1.0, Vector3::Zero(),
                                    control::motors_of_file(device_.motor)};
        for (std::size_t j = 0; j < 3; ++j) {
            inputs.R_hat_limit_Ohm[static_cast<Eigen::Index>(j)] =
                device::WindingGuard(device_.motor[j], device_.amplifier.max_cancelled_Ohm, 1.0)
                    .max_cancelled_Ohm();
        }
        return servo::limited(device_, law_(now, contact, control::Tuning{}, 0.0).command, inputs)
            .active_limits;
    }

    device::DeviceDescription device_;
    control::HapticLaw law_;
    Vector3 theta_rad_;
};

/// r of the kinematics: the distance of the tip from the base's axis.
double radius_m(const device::PhantomGeometry &geometry, const Vector3 &q_rad) {
    return geometry.upper_arm_m * std::cos(q_rad[1]) + geometry.forearm_m * std::sin(q_rad[2]);
}

/// (29) where l₁ = l₂ = l and N₂ = N₃ = N: the largest singular values of J are r/N₁ and
/// l √(1 + |sin(q₃ − q₂)|)/N.
std::optional<double> bound_of_even_links(const device::PhantomGeometry &geometry,
                                          const Vector3 &q_rad) {
    const double N = geometry.transmission_ratio[1];
    const double l_m = geometry.upper_arm_m;
    if (l_m != geometry.forearm_m || N != geometry.transmission_ratio[2]) {
        return std::nullopt;
    }
    const double base = radius_m(geometry, q_rad) / geometry.transmission_ratio[0];
    return 1.0 / std::max(base * base,
                          l_m * l_m / (N * N) * (1.0 + std::abs(std::sin(q_rad[2] - q_rad[1]))));
}

/// The smallest residual resistance that the limiter assumes: at the commutator's worst angle.
double worst_dR_Ohm(const device::MotorParameters &motor) {
    return control::Tuning{}.dR_Ohm - motor.commutation_ripple * motor.resistance_Ohm;
}

/// Under the transpose map K_x = α k_T K_P/dR in all directions.
LimitTrial too_much_force(const device::DeviceDescription &device, const Vector3 &q_rad) {
    const device::MotorParameters &motor = device.motor[1];
    const double force_N = servo::kLimiterShare * device.limits.tip_force_N;
    const std::optional<double> alpha = bound_of_even_links(device.geometry, q_rad);
    std::optional<double> predicted_mm;
    if (alpha) {
        predicted_mm = 1e3 * force_N * worst_dR_Ohm(motor) /
                       (*alpha * motor.torque_constant_Nm_per_A * control::Tuning{}.K_P_V_per_rad);
    }
    const LimitedLaw law(device, q_rad);
    return {{kMotorMethod,
             "pressed deeper than",
             "mm",
             "tuning firm, upwards: 95 % of " + with_unit(device.limits.tip_force_N, "N") +
                 ", where the force saturates",
             predicted_mm,
             {},
             {}},
            1e-3,
            100.0,
            false,
            [=](double depth_mm) {
                return !law.pressed(1e-3 * depth_mm, Vector3::UnitY()).holds_force();
            }};
}

/// Far out, a sideways push reaches the current limit of the base's motor before the force limit.
LimitTrial too_much_current(const device::DeviceDescription &device) {
    const Vector3 stretched_rad(0.0, 0.0, 50.0 * kRadiansPerDegree);
    const device::MotorParameters &motor = device.motor[0];
    const double lever_m =
        radius_m(device.geometry, stretched_rad) / device.geometry.transmission_ratio[0];
    const std::optional<double> alpha = bound_of_even_links(device.geometry, stretched_rad);
    std::optional<double> predicted_mm;
    if (alpha) {
        predicted_mm = 1e3 * servo::kLimiterShare * motor.peak_current_A * worst_dR_Ohm(motor) /
                       (control::Tuning{}.K_P_V_per_rad * *alpha * lever_m);
    }
    const LimitedLaw law(device, stretched_rad);
    return {{kMotorMethod,
             "pressed deeper than",
             "mm",
             "tuning firm, sideways at r " +
                 with_unit(std::round(1e3 * radius_m(device.geometry, stretched_rad)), "mm") +
                 ": 95 % of " + with_unit(motor.peak_current_A, "A"),
             predicted_mm,
             {},
             {}},
            1e-3,
            100.0,
            false,
            [=](double depth_mm) {
                return !law.pressed(1e-3 * depth_mm, Vector3::UnitX()).holds_force();
            }};
}

/// Free motion is free of force as long as e_W can cancel the back-EMF k_T θ̇.
LimitTrial too_much_voltage(const device::DeviceDescription &device, const Vector3 &q_rad) {
    const device::MotorParameters &motor = device.motor[1];
    const LimitedLaw law(device, q_rad);
    return {{kMotorMethod,
             "free motion faster than",
             "rad/s",
             "e_W reaches the supply of " + with_unit(motor.supply_V, "V"),
             motor.supply_V / motor.torque_constant_Nm_per_A,
             {},
             {}},
            1.0,
            1e4,
            false,
            [=](double rate_rad_per_s) { return !law.turning(rate_rad_per_s).voltage; }};
}

} // namespace

std::vector<LimitTrial> limiter_trials(const loops::StabilityCase &which) {
    return {too_much_force(which.device, which.q_rad), too_much_current(which.device),
            too_much_voltage(which.device, which.q_rad)};
}

} // namespace springdrive::limits
