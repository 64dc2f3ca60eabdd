// What is under the cursor, or anywhere along a line of sight; without OpenGL.
#pragma once

#include "app/view/camera.h"
#include "app/view/solids.h"
#include "app/view/view_state.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/scene/scene.h"

#include <optional>
#include <span>

namespace springdrive::app {

struct Ray {
    Vector3 origin_m{Vector3::Zero()};
    Vector3 direction{Vector3::Zero()}; ///< unit
};

/// From the eye through the centre of a pixel.
[[nodiscard]] Ray line_of_sight(const Camera &camera, const PixelPoint &pixel,
                                const PixelSize &viewport);

// The distance along the ray to the first triangle, from either side; nothing if it meets none.
// Every triangle is tried: 2 million take some 20 ms.

[[nodiscard]] std::optional<double> first_hit_m(const Ray &ray,
                                                std::span<const scene::VisualMesh> meshes);
[[nodiscard]] std::optional<double> first_hit_m(const Ray &ray, std::span<const Solid> solids);

/// The same for the plane y = height.
[[nodiscard]] std::optional<double> floor_hit_m(const Ray &ray, double floor_height_m);

/// Where a straight way first meets what can be touched, or comes within `reach_m` of it: a solid
/// from outside only. Takes microseconds, however large the surface.
[[nodiscard]] std::optional<SurfacePlace> first_touchable(const contact::HapticSurface &surface,
                                                          const Vector3 &from_m,
                                                          const Vector3 &to_m,
                                                          double reach_m = 1e-6);

/// What is straight below a point: what can be touched, else the floor; nothing below the floor.
[[nodiscard]] std::optional<SurfacePlace>
place_below(const contact::HapticSurface &surface, const Vector3 &point_m, double floor_height_m);

} // namespace springdrive::app
