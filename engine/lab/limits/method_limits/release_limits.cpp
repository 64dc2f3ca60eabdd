#include "engine/lab/limits/method_limits/limit_trials.h"

#include "device/core/phantom/kinematics.h"
#include "engine/control/motion_control.h"
#include "engine/lab/limits/method_limits/pressed_corner.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace springdrive::limits {

namespace {

constexpr double kHand_N = 40.0;   ///< the maximum force with which it presses
constexpr double kContact_s = 0.2; ///< the tip has left the walls by then

long ticks_in(double time_s, const loops::StabilityCase &which) {
    return std::lround(time_s / which.period_s);
}

/// K_x = α k̄ (27) where all motors are equal.
double tip_stiffness_N_per_m(const loops::StabilityCase &which) {
    const double alpha =
        control::alpha_bound(device::motor_jacobian(which.device.geometry, which.q_rad),
                             control::relative_stiffness(which.device));
    return alpha * control::mean_static_stiffness_Nm_per_rad(which.device, which.tuning);
}

/// The maximum speed of the tip per newton of the pressing force, by the linear loop without a
/// hand: from rest in a corner until it has left all three walls [m/s/N].
double speed_per_force(const loops::StabilityCase &which) {
    loops::StabilityCase alone = which;
    alone.hands = {loops::no_hand()};
    const loops::LoopMember member = loops::members(alone).front();
    const loops::SampledLaw law = loops::sampled_law(alone, member);
    const Eigen::MatrixXd map = loops::linear_loop(alone, member).one_period_map(law);
    const Matrix3 J = device::motor_jacobian(which.device.geometry, which.q_rad);
    const Vector3 pressed_m =
        -Vector3::Constant(1.0 / std::sqrt(3.0)) / tip_stiffness_N_per_m(which);
    Eigen::VectorXd state = Eigen::VectorXd::Zero(map.rows());
    const auto of = [&state](loops::StateBlock::Start block) {
        return state.segment<3>(3 * block);
    };
    of(loops::StateBlock::theta) = J.inverse() * pressed_m;
    const Matrix3 per_position = law.per_position;
    of(loops::StateBlock::current) = per_position * (J.inverse() * pressed_m) / which.tuning.dR_Ohm;
    double maximum = 0.0;
    for (long tick = 0; tick < ticks_in(kContact_s, which); ++tick) {
        state = map * state;
        maximum = std::max(maximum, Vector3(J * of(loops::StateBlock::rate)).norm());
        if (Vector3(J * of(loops::StateBlock::theta)).minCoeff() > 0.0) {
            break;
        }
    }
    return maximum;
}

bool keeps_running(const loops::StabilityCase &which, double force_N, double limit_m_per_s) {
    const double K = tip_stiffness_N_per_m(which);
    const double hand_N_per_m = which.hands.front().stiffness_N_per_m;
    PressedCorner corner(which, kHand_N);
    corner.inputs.limits.tip_speed_m_per_s = limit_m_per_s;
    corner.press(force_N * (K + hand_N_per_m) / K); // hand and contact are two springs in series
    if (corner.has_tripped()) {
        return false;
    }
    corner.let_go();
    constexpr double kWatched_s = 0.3;
    for (long tick = 0; tick < ticks_in(kWatched_s, which); ++tick) {
        corner.tick();
    }
    return !corner.has_tripped();
}

LimitTrial line_at(const loops::StabilityCase &which, double limit_m_per_s,
                   const std::string &setting) {
    constexpr double kMax_N = 7.0; // less than the limiter's maximum
    constexpr double kResolution = 1e-4;
    const double predicted_N = limit_m_per_s / speed_per_force(which);
    LimitTrial trial{{"servo",
                      "hand released while pressing with more than",
                      "N",
                      setting,
                      predicted_N < kMax_N ? std::optional(predicted_N) : std::nullopt,
                      {},
                      {}},
                     0.5,
                     kMax_N,
                     false,
                     [=](double force_N) { return keeps_running(which, force_N, limit_m_per_s); }};
    trial.resolution = kResolution;
    return trial;
}

} // namespace

std::vector<LimitTrial> release_trials(const loops::StabilityCase &which) {
    constexpr double kLowered_m_per_s = 0.2;
    loops::StabilityCase firm = which;
    firm.tuning = control::Tuning{};
    firm.freedom = loops::Freedom::three_motors;
    firm.hands = {loops::hand_of_firmness(1.0)};
    const double limit_m_per_s = firm.device.limits.tip_speed_m_per_s;
    return {
        line_at(firm, limit_m_per_s,
                "tuning firm, tip speed limited to " + with_unit(limit_m_per_s, "m/s") +
                    "; tried up to 7 N"),
        line_at(firm, kLowered_m_per_s,
                "tuning firm, tip speed limit lowered to " + with_unit(kLowered_m_per_s, "m/s"))};
}

} // namespace springdrive::limits
