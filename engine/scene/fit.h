// Placing a scene of unknown units in the device's workspace.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"

namespace springdrive::scene {

/// An axis-aligned box; empty until it includes a point.
struct BoundingBox {
    Vector3 lower;
    Vector3 upper;

    BoundingBox();
    void include(const Vector3 &point);
    [[nodiscard]] Vector3 extent() const { return upper - lower; }
};

/// p ↦ to + scale (p − from)
struct Fit {
    Vector3 from{Vector3::Zero()};
    Vector3 to_m{Vector3::Zero()};
    double scale = 1.0; ///< metres per unit

    [[nodiscard]] Vector3 operator()(const Vector3 &point) const {
        return to_m + scale * (point - from);
    }
};

/// How much of the workspace a fitted scene may fill, along each axis.
inline constexpr double kFilledShare = 0.6;

/// The largest uniform scale at which `box` fits into `kFilledShare` of the workspace, centred.
/// @throw InputError for a box without extent, or with coordinates too large to scale.
[[nodiscard]] Fit fit_into(const device::Workspace &workspace, const BoundingBox &box);

/// Whether `box`, in the device's frame, lies within the workspace.
[[nodiscard]] bool lies_within(const device::Workspace &workspace, const BoundingBox &box);

} // namespace springdrive::scene
