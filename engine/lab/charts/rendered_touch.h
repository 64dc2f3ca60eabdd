// What each way to render a contact makes of a tip pressed into a surface.
#pragma once

#include "base/vector.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/lab/rig/closest_point.h"
#include "engine/lab/rig/scenario/pressed_tips.h"

#include <span>
#include <vector>

namespace springdrive::charts {

/// What is felt at a tip; nothing at all where the method believes it to be free.
struct RenderedTouch {
    double depth_m = 0.0;            ///< under the surface, as the method sees it
    Vector3 normal{Vector3::Zero()}; ///< unit, along which the tip is pushed out; zero when free
};

/// The proxy, from outside above the first tip to one after the other. The clearance that it keeps
/// from every surface is not counted.
/// @pre there is a touch for each tip, and at least one
void follow_with_proxy(const contact::HapticSurface &surface, std::span<const rig::PressedTip> tips,
                       std::span<RenderedTouch> touches);

/// A penalty method: out to the closest point of the mesh.
/// @pre there is a touch for each tip
void push_to_closest_point(rig::ClosestPointFinder &mesh, std::span<const rig::PressedTip> tips,
                           std::span<RenderedTouch> touches);

/// How far from the truth the touches were.
struct TouchErrors {
    double depth_m = 0.0;       ///< 99th percentile of what depths are wrong by
    double direction_rad = 0.0; ///< the same of normals, where something was felt
    bool pops_through = false;  ///< some tip was pushed on, out of the surface's other side
};

/// @pre there is a touch for each tip, and at least one
[[nodiscard]] TouchErrors touch_errors(std::span<const rig::PressedTip> tips,
                                       std::span<const RenderedTouch> touches);

} // namespace springdrive::charts
