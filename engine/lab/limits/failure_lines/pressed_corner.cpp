#include "engine/lab/limits/failure_lines/pressed_corner.h"

#include "device/core/phantom/kinematics.h"
#include "engine/lab/limits/failure_lines/failing_shapes.h"

#include <cmath>
#include <utility>

namespace springdrive::limits {

namespace {

constexpr double kRoom_m = 0.05;
constexpr double kFromWalls_m = 3e-3; ///< from each wall at first
/// The servo waits for a tip at rest for 0.1 s and ramps for 1 s: by then it runs.
constexpr double kStartUp_s = 1.2;

simulated::SimulationOptions options_of(const loops::StabilityCase &which, double hand_force_N) {
    const loops::Hand &hand = which.hands.front();
    simulated::SimulationOptions options;
    options.servo_period_s = which.period_s;
    options.delay_periods = which.delay_periods;
    options.quantised_encoders = false;
    options.hand = {hand.mass_kg, hand.damping_Ns_per_m, hand.stiffness_N_per_m, hand_force_N, 1.0};
    options.effects = simulated::PlantEffects::none();
    options.effects.viscous_friction = true;
    options.effects.amplifier_limits = true;
    return options;
}

Vector3 corner_of(const loops::StabilityCase &which) {
    return device::tip_position_m(which.device.geometry, which.q_rad);
}

/// A box that is touched from within, its lowest corner at `corner_m`.
contact::TriangleSoup room(const Vector3 &corner_m) {
    contact::TriangleSoup soup = solid_box(corner_m, corner_m + Vector3::Constant(kRoom_m));
    for (auto &triangle : soup.triangles) {
        std::swap(triangle[1], triangle[2]);
    }
    return soup;
}

} // namespace

PressedCorner::PressedCorner(const loops::StabilityCase &which, double hand_force_N)
    : ServoRig(which.device, options_of(which, hand_force_N),
               corner_of(which) + Vector3::Constant(kFromWalls_m)),
      hand_N_per_m_(which.hands.front().stiffness_N_per_m), corner_m_(corner_of(which)),
      target_m_(corner_m_ + Vector3::Constant(kFromWalls_m)), walls_(room(corner_m_)) {
    inputs.surface = &walls_;
    inputs.tuning = which.tuning;
    run(kStartUp_s);
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
