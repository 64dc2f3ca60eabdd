#include "engine/servo/servo_loop.h"

#include "device/phantom/kinematics.h"
#include "engine/control/force_direction.h"
#include "engine/contact/haptic_surface.h"
#include "engine/control/motion_control.h"
#include "engine/control/parameters.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace springdrive {

namespace {

/// Below this a rendered force has no direction worth telling: it is of the size that single
/// encoder counts make of the velocity signal.
constexpr double kLeastForceWithDirection_N = 0.1;

/// A parameter changed in contact must not be felt as a blow: it glides to its new value with this
/// time constant, and is there when it is within this share of its range.
constexpr double kTuningGlide_s = 0.05;
constexpr double kTuningArrived = 1e-6;

/// Below this a set-point is where the tip is, and the rest is round-off: at η = 1, say.
constexpr double kLeastSetPointGap_m = 1e-6;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

} // namespace

ServoLoop::ServoLoop(HapticDevice &device, double period_s)
    : device_(device), period_s_(period_s), k_T_(torque_constants(device.description())),
      relative_stiffness_(relative_stiffness(device.description())),
      rad_per_count_(2.0 * std::numbers::pi / device.description().encoder_counts_per_turn),
      velocity_pole_(velocity_filter_pole(tuning_.lambda_rad_per_s, period_s)),
      safety_(device.description(), period_s) {}

void ServoLoop::stop() noexcept {
    command_ = DeviceCommand::braking();
    static_cast<void>(device_.exchange(command_));
}

void ServoLoop::take(const ServoInputs &inputs) noexcept {
    if (is_valid(inputs.tuning)) {
        approach(inputs.tuning);
    }
    if (inputs.reset_count != reset_count_) {
        reset_count_ = inputs.reset_count;
        safety_.reset();
    }
}

void ServoLoop::approach(const Tuning &wanted) noexcept {
    const double share = tick_ == 0 ? 1.0 : -std::expm1(-period_s_ / kTuningGlide_s);
    tuning_.map = wanted.map;
    tuning_.alpha_mode = wanted.alpha_mode;
    for (const Parameter &parameter : kParameters) {
        double &value = tuning_.*parameter.value;
        const double gap = wanted.*parameter.value - value;
        const bool arrived =
            std::abs(gap) < kTuningArrived * (parameter.highest - parameter.lowest);
        value = arrived ? wanted.*parameter.value : value + share * gap;
    }
    velocity_pole_ = velocity_filter_pole(tuning_.lambda_rad_per_s, period_s_);
}

Configuration ServoLoop::configuration(const DeviceState &state) noexcept {
    const PhantomGeometry &geometry = device_.description().geometry;
    Configuration now;
    now.theta_rad = rad_per_count_ * Vector3(state.counts[0], state.counts[1], state.counts[2]);
    if (tick_ == 0) {
        velocity_filter_.reset(now.theta_rad);
    }
    now.theta_rate_rad_per_s = velocity_filter_.update(now.theta_rad, velocity_pole_, period_s_);
    const Vector3 q_rad = joint_from_motor(geometry, now.theta_rad);
    now.tip_m = tip_position_m(geometry, q_rad);
    now.J = motor_jacobian(geometry, q_rad);
    return now;
}

Contact ServoLoop::touch(const Vector3 &tip_m, const ServoInputs &inputs) noexcept {
    if (tick_ == 0 || inputs.scene_id != scene_id_) {
        scene_id_ = inputs.scene_id;
        proxy_.reset(tip_m);
    }
    if (inputs.mesh == nullptr) {
        Contact free;
        free.x0_m = tip_m;
        return free;
    }
    return proxy_.update(*inputs.mesh, tip_m);
}

double ServoLoop::alpha(double bound, const ServoInputs &inputs) const noexcept {
    switch (tuning_.alpha_mode) {
    case AlphaMode::global:
        return inputs.global_alpha_rad2_per_m2;
    case AlphaMode::by_hand:
        return tuning_.alpha_rad2_per_m2;
    case AlphaMode::on_the_fly:
        break;
    }
    return bound;
}

DeviceCommand ServoLoop::law(const Configuration &now, const ServoInputs &inputs,
                             ServoSample &sample) noexcept {
    const Contact &contact = sample.contact;
    sample.eta = combined_eta(contact.eta, tuning_.eta);
    sample.alpha_bound_rad2_per_m2 = alpha_bound(now.J, relative_stiffness_);
    sample.alpha_rad2_per_m2 = alpha(sample.alpha_bound_rad2_per_m2, inputs);

    const TipSetPoint target =
        contact_set_point(now.tip_m, now.tip_velocity_m_per_s(), contact, sample.eta);
    const std::optional<MotorSetPoint> inverse =
        inverse_map(device_.description().geometry, now, target);
    const MotorSetPoint transpose =
        transpose_map(now, target, sample.alpha_rad2_per_m2, relative_stiffness_);
    const MotorSetPoint used =
        tuning_.map == MotionMap::transpose ? transpose : inverse.value_or(no_force(now));

    sample.inverse_possible = inverse.has_value();
    sample.map = tuning_.map;
    sample.x_Sd_m = target.x_Sd_m;
    sample.theta_Sd_rad = used.theta_Sd_rad;
    const auto static_error = [&](const MotorSetPoint &set_point) {
        return direction_error_rad(
            static_tip_force(now.J, relative_stiffness_, set_point.theta_Sd_rad - now.theta_rad),
            contact.normal);
    };
    const bool pushes =
        contact.touching && (target.x_Sd_m - now.tip_m).norm() > kLeastSetPointGap_m;
    sample.inverse_error_rad = pushes && inverse ? static_error(*inverse) : kNone;
    sample.transpose_error_rad = pushes ? static_error(transpose) : kNone;

    DeviceCommand wanted;
    wanted.e_W_V = drift_compensation_V(k_T_, tuning_, now, used);
    for (std::size_t j = 0; j < 3; ++j) {
        const MotorParameters &motor = device_.description().motor[j];
        wanted.cancelled_resistance_Ohm[static_cast<Eigen::Index>(j)] =
            motor.resistance_Ohm - residual_resistance_Ohm(motor, tuning_.dR_Ohm);
    }
    return wanted;
}

ServoSample ServoLoop::update(const DeviceState &state, const ServoInputs &inputs) noexcept {
    take(inputs);
    ServoSample sample;
    sample.tick = tick_;
    sample.time_s = static_cast<double>(tick_) * period_s_;
    sample.counts = state.counts;
    sample.current_A = state.current_A;

    const Configuration now = configuration(state);
    sample.theta_rad = now.theta_rad;
    sample.theta_rate_rad_per_s = now.theta_rate_rad_per_s;
    sample.tip_m = now.tip_m;
    sample.contact = touch(now.tip_m, inputs);
    sample.scene_id = scene_id_;
    const DeviceCommand wanted = law(now, inputs, sample);

    sample.tip_force_N = static_tip_force(now.J, k_T_, state.current_A);
    sample.rendered_error_rad =
        sample.contact.touching && sample.tip_force_N.norm() > kLeastForceWithDirection_N
            ? direction_error_rad(sample.tip_force_N, sample.contact.normal)
            : kNone;

    SafetyMonitor::Measurement measured;
    measured.health = state.health;
    measured.tip_velocity_m_per_s = now.tip_velocity_m_per_s();
    measured.tip_force_N = sample.tip_force_N;
    measured.current_A = state.current_A;
    measured.all_finite = now.tip_m.allFinite() && sample.contact.x0_m.allFinite();
    command_ = safety_.pass(wanted, measured, inputs.emergency_stop);
    sample.command = command_;
    sample.safety = safety_.status();
    sample.winding = safety_.windings();
    ++tick_;
    return sample;
}

} // namespace springdrive
