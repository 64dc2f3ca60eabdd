// Where, and on which surface, the force of the inverse map (18) deviates most from the normal.
//
// At rest a tip held at depth δ in a surface with unit normal n feels
//
//   inverse (21):    F = δ J⁻ᵀ K_q J⁻¹ n
//   transpose (26):  F = δ α k̄ J⁻ᵀ D Jᵀ n
//
// where D is diagonal: each motor's true stiffness over the one that the law expects. With D = I
// the transpose map errs nowhere (27); of a real device, whose dR differ, it does.
//
// The search is over poses and normals: all points of a grid, then uphill from the best of them.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"
#include "engine/control/tuning.h"

#include <functional>
#include <optional>

namespace springdrive::loops {

/// A press against a surface, at rest.
struct Press {
    Vector3 tip_m{Vector3::Zero()};
    Vector3 q_rad{Vector3::Zero()};
    Vector3 normal{Vector3::UnitY()}; ///< unit, out of the surface
};

/// (21) at a configuration [N/m]. @pre J is regular
[[nodiscard]] Matrix3 inverse_tip_stiffness(const device::DeviceDescription &device,
                                            const control::Tuning &tuning, const Vector3 &q_rad);

/// The angle from the normal to the inverse map's force.
[[nodiscard]] double inverse_error_rad(const device::DeviceDescription &device,
                                       const control::Tuning &tuning, const Press &press);

/// The largest angle from the normal to the transpose map's force, if each motor's stiffness may
/// differ by `share` from what the law expects, either way. It is reached where each differs by
/// all of it: forces within an angle of the normal are a convex cone.
[[nodiscard]] double transpose_error_rad(const device::DeviceDescription &device,
                                         const Press &press, double share);

/// What is searched.
struct PressSearch {
    control::Tuning tuning;
    Vector3 lower_m{Vector3::Zero()}; ///< of a box of tip positions
    Vector3 upper_m{Vector3::Zero()};
    int points_per_axis = 17; ///< of the box, where it is not flat
    int normal_frequency = 8; ///< normals are at most 2 rad over this apart
    double margin_rad = 0.0;  ///< before joint limits
    double depth_m = 1e-3;    ///< at which the inverse map requests no more than half of the
                              ///< device's limits of current, voltage and tip force
    /// Which presses count; empty: all.
    std::function<bool(const Press &)> accepts;
};

/// All that the device can reach.
[[nodiscard]] PressSearch everywhere(const device::DeviceDescription &device,
                                     const control::Tuning &tuning);

/// Presses that are easy to make and to see: in the middle of the inner 80 % of the workspace, 10°
/// before the soft edge, from above on what slopes by 45° at most, 15 mm or more below a tip that
/// starts in the zero pose, with the forearm 30° or more off the surface.
[[nodiscard]] PressSearch with_ease(const device::DeviceDescription &device,
                                    const control::Tuning &tuning);

/// The press whose inverse map errs most. Takes a fraction of a second. Nothing if no press
/// of the grid counts.
[[nodiscard]] std::optional<Press> most_wrong_press(const device::DeviceDescription &device,
                                                    const PressSearch &search);

} // namespace springdrive::loops
