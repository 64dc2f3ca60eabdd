// The contact that is reported for a proxy's place of rest.
#pragma once

#include "base/vector.h"
#include "engine/contact/contact.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/contact/proxy/proxy_solver.h"
#include "engine/contact/proxy/shape_slide.h"

#include <cstdint>

namespace springdrive::contact {

/// For a proxy that touches nothing.
[[nodiscard]] Contact free_contact(const Vector3 &point_m) noexcept;

/// For a proxy held by its planes, at least one. RT-safe.
[[nodiscard]] Contact resting_contact(const HapticSurface &surface, const Vector3 &tip_m,
                                      const Rest &rest) noexcept;

/// The same where it has come to rest at the end of a slide over a shape. RT-safe.
[[nodiscard]] Contact resting_contact(const HapticSurface &surface, std::uint32_t shape_obstacle,
                                      const ShapeSlide &slide, double reach_m) noexcept;

} // namespace springdrive::contact
