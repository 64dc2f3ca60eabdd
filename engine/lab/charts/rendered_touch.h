// The contact that each rendering method computes for a tip pressed into a surface.
#pragma once

#include "base/vector.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/lab/rig/closest_point.h"
#include "engine/lab/rig/scenario/pressed_tips.h"

#include <span>
#include <vector>

namespace springdrive::charts {

/// The rendered contact at a tip; all zero where the method takes the tip as free.
struct RenderedTouch {
    double depth_m = 0.0;            ///< below the surface, according to the method
    Vector3 normal{Vector3::Zero()}; ///< unit, along which the tip is pushed out; zero when free
};

/// The proxy: starts outside above the first tip and follows all tips. Its clearance from every
/// surface is not counted.
/// @pre there is a touch for each tip, and at least one
void follow_with_proxy(const contact::HapticSurface &surface, std::span<const rig::PressedTip> tips,
                       std::span<RenderedTouch> touches);

/// A penalty method: pushes out to the closest point of the mesh.
/// @pre there is a touch for each tip
void push_to_closest_point(rig::ClosestPointFinder &mesh, std::span<const rig::PressedTip> tips,
                           std::span<RenderedTouch> touches);

/// The errors of the touches.
struct TouchErrors {
    double depth_m = 0.0;       ///< 99th percentile of the error of depths
    double direction_rad = 0.0; ///< the same for normals, where there was contact
    bool pops_through = false;  ///< some tip was pushed out of the surface's other side
};

/// @pre there is a touch for each tip, and at least one
[[nodiscard]] TouchErrors touch_errors(std::span<const rig::PressedTip> tips,
                                       std::span<const RenderedTouch> touches);

} // namespace springdrive::charts
