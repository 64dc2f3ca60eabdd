#include "engine/lab/limits/locked_device.h"

#include "base/eigenvalues.h"
#include "base/input_error.h"
#include "engine/control/motion_control.h"
#include "engine/lab/loops/link_plane.h"
#include "engine/lab/rig/scenario/scenarios.h"
#include "engine/lab/rig/servo_rig.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace springdrive::limits {

namespace {

/// Runs until `until_s`. Returns the mean force on the sensor until then [N].
/// @param measures  whether the servo must not reduce the force
Vector3 mean_force_N(rig::ServoRig &rig, double until_s, bool measures = false) {
    Vector3 sum = Vector3::Zero();
    int ticks = 0;
    while (rig.truth().time_s < until_s - 0.5 * rig.loop().period_s()) {
        const servo::ServoSample &sample = rig.tick();
        if (rig.has_tripped()) {
            throw InputError("locked device: the safety monitor tripped (" +
                             servo::description(sample.safety) +
                             "); choose a softer tuning or another configuration");
        }
        if (measures && (sample.active_limits.holds_force() || sample.active_limits.voltage)) {
            throw InputError("locked device: the servo reduced the force to stay within its "
                             "limits; choose a softer tuning or another configuration");
        }
        sum -= rig.truth().hand_force_N;
        ++ticks;
    }
    return sum / std::max(1, ticks);
}

const loops::Matrix2 &stiffness_under(const loops::PlanarStiffness &stiffness,
                                      control::MotionMap map) {
    return map == control::MotionMap::inverse ? stiffness.inverse : stiffness.transpose;
}

} // namespace

LockedForce press_locked_device(const device::DeviceDescription &device,
                                const LockedDeviceOptions &options, control::MotionMap map,
                                double normal_rad) {
    rig::check_configuration(device, options.q_rad);
    const loops::PlanarStiffness stiffness =
        loops::planar_stiffness(device, options.tuning, options.q_rad);
    const Eigen::Matrix<double, 3, 2> plane = loops::link_plane(options.q_rad[0]);
    const loops::Vector2 n = loops::direction_at(normal_rad);
    const Vector3 normal = plane * n;
    rig::ScenarioSetting setting{device, options.tuning, options.q_rad, options.servo_period_s};
    setting.tuning.map = map;
    setting.tuning.alpha_mode = control::AlphaMode::global;
    constexpr double kExercise_s = 2.5;
    const double exercise_s = options.observes_resistance ? kExercise_s : 0.0;
    rig::ServoRig rig(rig::vice_scenario(setting, {normal, options.penetration_m, options.effects,
                                                   options.device_seed, exercise_s}));
    rig.inputs.observes_resistance = options.observes_resistance;
    rig.inputs.global_alpha_rad2_per_m2 = stiffness.alpha_rad2_per_m2;
    static_cast<void>(mean_force_N(rig, exercise_s + rig::ViceOptions::kZeroFrom_s));
    const Vector3 zero_N = mean_force_N(rig, exercise_s + rig::ViceOptions::kPressFrom_s);
    static_cast<void>(mean_force_N(rig, exercise_s + rig::ViceOptions::kMeasureFrom_s));
    const Vector3 reading_N =
        mean_force_N(rig, exercise_s + rig::ViceOptions::kMeasureUntil_s, true);

    LockedForce force;
    force.measured_N = plane.transpose() * (reading_N - zero_N);
    force.predicted_N = options.penetration_m * stiffness_under(stiffness, map) * n;
    force.error_rad = loops::signed_angle_rad(n, force.measured_N);
    force.predicted_error_rad = loops::signed_angle_rad(n, force.predicted_N);
    return force;
}

double breakaway_force_N(const device::DeviceDescription &device, const Vector3 &q_rad) {
    const loops::Matrix2 J = loops::planar_jacobian(device.geometry, q_rad);
    const loops::Vector2 torque_Nm = device.friction.coulomb_Nm.tail<2>().cwiseQuotient(
        device.geometry.transmission_ratio.tail<2>()); // at the motors
    const auto force_N = [&](double sign) -> loops::Vector2 {
        return J.transpose().inverse() * loops::Vector2(torque_Nm[0], sign * torque_Nm[1]);
    };
    return std::max(force_N(1.0).norm(), force_N(-1.0).norm());
}

double harmless_penetration_m(const device::DeviceDescription &device,
                              const control::Tuning &tuning, const Vector3 &q_rad,
                              control::MotionMap map) {
    constexpr double kMaxPenetration_m = 4e-3;
    constexpr double kShare = 0.5;
    const loops::PlanarStiffness stiffness = loops::planar_stiffness(device, tuning, q_rad);
    const loops::Matrix2 &K = stiffness_under(stiffness, map);
    double penetration_m =
        std::min(kMaxPenetration_m,
                 kShare * device.limits.tip_force_N / symmetric_modes(K).eigenvalues.maxCoeff());
    const loops::Matrix2 torque_per_metre =
        loops::planar_jacobian(device.geometry, q_rad).transpose() * K;
    for (Eigen::Index j = 0; j < 2; ++j) {
        const device::MotorParameters &motor = device.motor[static_cast<std::size_t>(j + 1)];
        const double amperes_per_metre =
            torque_per_metre.row(j).norm() / motor.torque_constant_Nm_per_A;
        penetration_m = std::min(penetration_m, kShare * motor.peak_current_A / amperes_per_metre);
    }
    return penetration_m;
}

} // namespace springdrive::limits
