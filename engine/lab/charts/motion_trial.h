// The static force of each map from the tip's set-point to the motors' on a tip held inside a
// surface, at any place of the workspace and for any orientation of the surface.
#pragma once

#include "device/core/device_description.h"
#include "engine/control/motion_control.h"
#include "engine/control/tuning.h"

#include <optional>
#include <vector>

namespace springdrive::charts {

/// A map and, for the transpose, its α.
struct MotionMethod {
    control::MotionMap map = control::MotionMap::transpose;
    control::AlphaMode alpha_mode = control::AlphaMode::on_the_fly;
    double alpha_rad2_per_m2 = 0.0; ///< of the modes global and by_hand
};

/// The set-point that a method commands.
/// @return nothing where the inverse map has no solution
[[nodiscard]] std::optional<control::MotorSetPoint>
motor_set_point(const device::DeviceDescription &device, const MotionMethod &method,
                const control::Configuration &now, const control::TipSetPoint &target);

/// A tip held at rest inside a wall.
struct HeldTip {
    Vector3 q_rad{Vector3::Zero()};
    Vector3 normal{Vector3::UnitY()}; ///< unit, out of the wall
    double depth_m = 1e-3;            ///< inside
    int counts_per_turn = 0;          ///< of the encoders; 0: exact
};

/// The force of the device on what holds it [N], by (19) and (22): J⁻ᵀ K_q (θ_Sd − θ) with K_q
/// diagonal, K_DC (13) of each motor. Method and proxy use θ as the encoders show it; J⁻ᵀ is exact.
/// Zero where the inverse map has no solution.
[[nodiscard]] Vector3 force_on_holder_N(const device::DeviceDescription &device,
                                        const control::Tuning &tuning, const MotionMethod &method,
                                        const HeldTip &tip);

/// Joint angles at the points of a grid in the workspace that the tip can reach.
[[nodiscard]] std::vector<Vector3> workspace_angles_rad(const device::DeviceDescription &device,
                                                        int points_per_axis);

/// `count` directions, spread evenly over the sphere.
[[nodiscard]] std::vector<Vector3> spread_normals(int count);

/// Whether every mode of a method's contact decays at a configuration: with a > 0 the eigenvalues
/// of α W⁻¹ JᵀJ, or 1 under the inverse map, each is the loop of one motor with η = 1 − a, as in
/// docs/design.md, "Contact and maps". A mode moves several motors; it must be stable on each of
/// them.
[[nodiscard]] bool is_stable_at(const device::DeviceDescription &device,
                                const control::Tuning &tuning, const MotionMethod &method,
                                const Vector3 &q_rad);

} // namespace springdrive::charts
