// Coulomb's law for a proxy: how much of the way to where it would rest without friction it goes.
//
// The force on the tip has to lie in the friction cone about the normal, which at a distance N from
// the tip is a circle of radius μ N about the point without friction: Zilles and Salisbury (see
// proxy.h), and W. Harwin and N. Melder, "Improved haptic rendering for multi-finger manipulation
// using friction cone based god-objects", 2002. There the god-object moves to the nearest point of
// that circle; here it stops where its own path over the surface enters it, which on a plane is the
// same, and over an edge or a bend never leaves the surface.
#pragma once

#include "engine/contact/mesh/surface_material.h"
#include "engine/contact/proxy/proxy_path.h"

#include <cstddef>

namespace springdrive::contact {

/// A place on a path, and whether friction holds the proxy there.
struct FrictionStop {
    std::size_t piece = 0; ///< it lies between points `piece` and `piece + 1`
    Vector3 point_m{Vector3::Zero()};
    bool sticks = false; ///< at the first point: it has not moved
};

/// Where on the path of a proxy without friction one with friction stays.
///
/// The path's end is N from the tip, along the force that the surface alone would make; a proxy
/// that stays behind by t makes a force at an angle of atan(t/N) to that. It sticks as long as
/// t <= μ N, with the static coefficient if it stuck before and the dynamic one if it was sliding;
/// if not, it slides on to where t = μ N with the dynamic one. RT-safe.
///
/// @param first     where on the path it was, or first touched
/// @param normal_m  N
[[nodiscard]] FrictionStop hold_back(const ProxyPath &path, std::size_t first, double normal_m,
                                     const SurfaceMaterial &material, bool was_sliding) noexcept;

} // namespace springdrive::contact
