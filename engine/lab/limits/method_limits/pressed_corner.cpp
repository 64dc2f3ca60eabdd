#include "engine/lab/limits/method_limits/pressed_corner.h"

#include "device/core/phantom/kinematics.h"
#include "engine/lab/limits/stability_simulation.h"

#include <cmath>

namespace springdrive::limits {

namespace {

rig::Scenario corner(const loops::StabilityCase &which, double hand_force_N) {
    return rig::corner_scenario(setting_of(which),
                                simulated_hand(which.hands.front(), hand_force_N));
}

} // namespace

PressedCorner::PressedCorner(const loops::StabilityCase &which, double hand_force_N)
    : PressedCorner(which, corner(which, hand_force_N)) {}

PressedCorner::PressedCorner(const loops::StabilityCase &which, const rig::Scenario &scenario)
    : ServoRig(scenario), hand_N_per_m_(which.hands.front().stiffness_N_per_m),
      corner_m_(device::tip_position_m(which.device.geometry, which.q_rad)),
      target_m_(scenario.start_m) {
    run(scenario.duration_s);
}

void PressedCorner::press(double force_N) {
    constexpr double kSettles_s = 0.6;
    target_m_ = corner_m_ - Vector3::Constant(force_N / hand_N_per_m_ / std::sqrt(3.0));
    phantom().set_hand_target(target_m_);
    run(kSettles_s);
}

void PressedCorner::nudge() {
    constexpr double kNudge_m = 1e-4;
    target_m_ += kNudge_m * Vector3(0.6, 0.64, 0.48);
    phantom().set_hand_target(target_m_);
}

} // namespace springdrive::limits
