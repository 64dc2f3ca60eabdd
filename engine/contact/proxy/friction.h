// Coulomb friction for a proxy: how far along its frictionless path it moves.
//
// The force on the tip has to lie in the friction cone about the normal, which at a distance N from
// the tip is a circle of radius μ N about the frictionless point: Zilles and Salisbury (see
// proxy.h), and W. Harwin and N. Melder, "Improved haptic rendering for multi-finger manipulation
// using friction cone based god-objects", 2002. There the god-object moves to the nearest point of
// that circle; here it stops where its own path over the surface enters it, which is the same on a
// plane, and never leaves the surface at an edge or a bend.
#pragma once

#include "engine/contact/mesh/surface_material.h"
#include "engine/contact/proxy/proxy_path.h"

#include <cstddef>

namespace springdrive::contact {

/// A point of a path, and whether friction holds the proxy there.
struct FrictionStop {
    std::size_t piece = 0; ///< the point lies between points `piece` and `piece + 1` of the path
    Vector3 point_m{Vector3::Zero()};
    bool sticks = false; ///< at the first point: it has not moved
};

/// Where a proxy with friction stops on the path of one without.
///
/// The path's end is N from the tip, along the force without friction; a proxy that lags by t makes
/// a force at an angle of atan(t/N) to that. It sticks as long as t <= μ N, with the static
/// coefficient if it stuck before and the dynamic one if it was sliding; otherwise it slides on to
/// where t = μ N with the dynamic one. RT-safe.
///
/// @param first index of the point at which it was, or first touched
/// @param normal_m  N
[[nodiscard]] FrictionStop stop_by_friction(const ProxyPath &path, std::size_t first,
                                            double normal_m, const SurfaceMaterial &material,
                                            bool was_sliding) noexcept;

} // namespace springdrive::contact
