// What holds the tip, as motion control sees it: a point, a plane, a surface, or nothing.
#pragma once

#include "engine/contact/contact.h"
#include "engine/contact/proxy/haptic_surface.h"

#include <cstdint>
#include <functional>

namespace springdrive::rig {

/// The contact of a tip. It may depend on earlier tips, as a proxy does.
using Constraint = std::function<contact::Contact(const Vector3 &tip_m)>;

[[nodiscard]] Constraint free_space();

/// Holds the tip at a point in all directions, with η = 0.
[[nodiscard]] Constraint tied_to(const Vector3 &point_m);

/// Whether a plane also holds a tip outside it.
enum class Sides : std::uint8_t { one, both };

/// A plane through a point, with η = 0.
/// @param normal  unit, out of the plane
[[nodiscard]] Constraint plane(const Vector3 &point_m, const Vector3 &normal, Sides sides);

/// A surface touched by a proxy that starts at the first tip.
/// @param surface  must outlive the constraint
[[nodiscard]] Constraint surface(const contact::HapticSurface &surface);

} // namespace springdrive::rig
