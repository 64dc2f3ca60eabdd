#include "device/simulated/simulated_phantom.h"

#include "base/input_error.h"
#include "device/motor/motor.h"
#include "device/phantom/kinematics.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace springdrive {

namespace {

/// An encoder this much finer does not quantise for any purpose here, and its counts still fit.
constexpr int kFineEncoderFactor = 10'000;

/// How quickly a hand follows what the eye asks of it: the corner of the smoothing of
/// `set_hand_target`, which also turns the steps of a 60 Hz mouse into a smooth motion.
constexpr double kHandReachRate = 40.0; // rad/s

struct AppliedVoltage {
    double voltage_V = 0.0;
    double resistance_Ohm = 0.0; ///< what of R is left in the winding's way
};

/// (6) within the supply: e_A = R̂ i + e_W, or the rail, behind which the whole R is back.
AppliedVoltage amplifier(const MotorParameters &motor, double e_W_V,
                         double cancelled_resistance_Ohm, double current_A) {
    const double e_A_V = cancelled_resistance_Ohm * current_A + e_W_V;
    if (std::abs(e_A_V) > motor.supply_V) {
        return {std::copysign(motor.supply_V, e_A_V), motor.resistance_Ohm};
    }
    return {e_W_V, motor.resistance_Ohm - cancelled_resistance_Ohm};
}

Vector3 limited(const Vector3 &vector, double greatest_norm) {
    const double norm = vector.norm();
    return norm > greatest_norm ? Vector3(vector * (greatest_norm / norm)) : vector;
}

void check_options(const SimulationOptions &options) {
    const HandParameters &hand = options.hand;
    const bool good = options.servo_period_s > 0.0 && options.longest_step_s > 0.0 &&
                      hand.mass_kg >= 0.0 && hand.damping_Ns_per_m >= 0.0 &&
                      hand.stiffness_N_per_m >= 0.0 && hand.greatest_force_N >= 0.0 &&
                      hand.greatest_speed_m_per_s > 0.0;
    if (!good) {
        throw InputError("simulated device: periods and the hand's speed must be positive, its "
                         "mass, damping, stiffness and force not negative");
    }
    if (options.delay_samples < 0 || options.delay_samples > SimulatedPhantom::kLongestDelay) {
        throw InputError("simulated device: the delay is " + std::to_string(options.delay_samples) +
                         " samples; it must be 0 to " +
                         std::to_string(SimulatedPhantom::kLongestDelay));
    }
}

} // namespace

SimulatedPhantom::SimulatedPhantom(const DeviceDescription &description,
                                   const SimulationOptions &options, const Vector3 &start_tip_m)
    : description_(description), options_(options), hand_target_(start_tip_m) {
    check_options(options);
    const std::optional<Vector3> q_rad = joint_angles_rad(description.geometry, start_tip_m);
    if (!q_rad) {
        throw InputError("simulated device: its tip cannot start at (" +
                         std::to_string(start_tip_m.x()) + ", " + std::to_string(start_tip_m.y()) +
                         ", " + std::to_string(start_tip_m.z()) +
                         ") m, which is out of reach; choose a point in the workspace");
    }
    if (!options.quantised_encoders) {
        description_.encoder_counts_per_turn *= kFineEncoderFactor;
    }
    counts_per_rad_ = description_.encoder_counts_per_turn / (2.0 * std::numbers::pi);
    truth_.theta_rad = motor_from_joint(description.geometry, *q_rad);
    truth_.tip_m = start_tip_m;
    truth_.hand_target_m = start_tip_m;
    hand_.position_m = start_tip_m;
}

DeviceState SimulatedPhantom::exchange(const DeviceCommand &command) noexcept {
    std::shift_right(pending_.begin(), pending_.end(), 1);
    pending_.front() = command.e_W_V.allFinite() && command.cancelled_resistance_Ohm.allFinite()
                           ? command
                           : DeviceCommand::braking();
    const DeviceCommand &applied = pending_[static_cast<std::size_t>(options_.delay_samples)];

    const int steps =
        std::max(1, static_cast<int>(std::ceil(options_.servo_period_s / options_.longest_step_s -
                                               1e-9))); // round-off must not add a step
    const double h = options_.servo_period_s / steps;
    Vector3 impulse = Vector3::Zero();
    for (int i = 0; i < steps; ++i) {
        impulse += h * step(applied, h);
    }
    truth_.hand_force_N = impulse / options_.servo_period_s;

    DeviceState state;
    for (std::size_t motor = 0; motor < 3; ++motor) {
        state.counts[motor] = static_cast<std::int32_t>(
            std::lround(truth_.theta_rad[static_cast<Eigen::Index>(motor)] * counts_per_rad_));
    }
    state.current_A = truth_.current_A;
    return state;
}

void SimulatedPhantom::move_hand_target(double h) noexcept {
    const double middle_s = truth_.time_s + 0.5 * h;
    if (options_.path) {
        hand_ = options_.path->at(middle_s);
    } else {
        // Critically damped, semi-implicit: stable for any h below 1/rate.
        const Vector3 gap = hand_target_.latest() - hand_.position_m;
        hand_.velocity_m_per_s +=
            h * kHandReachRate * (kHandReachRate * gap - 2.0 * hand_.velocity_m_per_s);
        hand_.velocity_m_per_s =
            limited(hand_.velocity_m_per_s, options_.hand.greatest_speed_m_per_s);
        hand_.position_m += h * hand_.velocity_m_per_s;
    }
    truth_.hand_target_m = hand_.position_m;
}

/// One sub-step; returns the hand's force on the tip, its mean over the sub-step [N].
Vector3 SimulatedPhantom::step(const DeviceCommand &command, double h) noexcept {
    move_hand_target(h);
    const PhantomGeometry &geometry = description_.geometry;
    const HandParameters &hand = options_.hand;
    const Vector3 &v0 = truth_.theta_rate_rad_per_s;

    // The mean velocity is not known yet; extrapolated from the last one it is second order.
    const Vector3 v_expected = 2.0 * v0 - last_mean_rate_rad_per_s_;
    const Vector3 q_middle = joint_from_motor(geometry, truth_.theta_rad + 0.5 * h * v0);
    const Vector3 ratio_inverse = geometry.transmission_ratio.cwiseInverse();
    const Matrix3 J = joint_jacobian(geometry, q_middle) * ratio_inverse.asDiagonal();
    const Matrix3 J_rate =
        joint_jacobian_rate(geometry, q_middle, joint_from_motor(geometry, v_expected)) *
        ratio_inverse.asDiagonal();
    const Matrix3 Jt_J = J.transpose() * J;

    // The hand's spring pulls at the middle of the step, half of it known beforehand; at its
    // greatest force it no longer stiffens.
    const Vector3 pull = hand.stiffness_N_per_m * (hand_.position_m - truth_.tip_m);
    const bool saturated = pull.norm() > hand.greatest_force_N;
    const double stiffness = saturated ? 0.0 : hand.stiffness_N_per_m;
    const Vector3 known_force =
        limited(pull, hand.greatest_force_N) + hand.damping_Ns_per_m * hand_.velocity_m_per_s;
    const double force_per_velocity = hand.damping_Ns_per_m + 0.5 * h * stiffness;

    const double mass = description_.tip_mass_kg + hand.mass_kg;
    Matrix3 inertia = mass * Jt_J;
    Matrix3 resistance = force_per_velocity * Jt_J;
    Vector3 torque = J.transpose() * (known_force - mass * (J_rate * v_expected));

    Vector3 net_voltage = Vector3::Zero();
    std::array<WindingStep, 3> winding;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const auto index = static_cast<std::size_t>(j);
        const MotorParameters &motor = description_.motor[index];
        const AppliedVoltage applied = amplifier(
            motor, command.e_W_V[j], command.cancelled_resistance_Ohm[j], truth_.current_A[j]);
        winding[index] = winding_step(motor, applied.resistance_Ohm, h);
        net_voltage[j] = applied.voltage_V;
        const double k_T = motor.torque_constant_Nm_per_A;
        inertia(j, j) += motor.rotor_inertia_kg_m2;
        resistance(j, j) +=
            description_.joint_damping_Nms_per_rad * ratio_inverse[j] * ratio_inverse[j] +
            k_T * k_T * winding[index].mean_gain_A_per_V;
        torque[j] += k_T * (winding[index].mean_decay * truth_.current_A[j] +
                            winding[index].mean_gain_A_per_V * net_voltage[j]);
    }

    // Momentum over the step: inertia · 2(v̄ − v₀)/h = torque − resistance · v̄.
    const Matrix3 system = (2.0 / h) * inertia + resistance;
    const Vector3 v_mean = system.ldlt().solve((2.0 / h) * (inertia * v0) + torque);

    for (Eigen::Index j = 0; j < 3; ++j) {
        const auto index = static_cast<std::size_t>(j);
        const double back_emf = description_.motor[index].torque_constant_Nm_per_A * v_mean[j];
        truth_.current_A[j] = winding[index].decay * truth_.current_A[j] +
                              winding[index].gain_A_per_V * (net_voltage[j] - back_emf);
    }
    const Vector3 v1 = 2.0 * v_mean - v0;
    const Vector3 acceleration = J * ((v1 - v0) / h) + J_rate * v_expected;
    truth_.theta_rad += h * v_mean;
    truth_.theta_rate_rad_per_s = v1;
    last_mean_rate_rad_per_s_ = v_mean;
    truth_.tip_m = tip_position_m(geometry, joint_from_motor(geometry, truth_.theta_rad));
    truth_.tip_velocity_m_per_s = J * v1;
    truth_.time_s += h;
    // What the hand's spring and damper give, less what its own mass takes.
    return known_force - force_per_velocity * (J * v_mean) - hand.mass_kg * acceleration;
}

} // namespace springdrive
