// The shapes on which rendering methods are tried, each as meshes of any fineness and, where one
// exists, as a primitive; and the contact that each method computes for a tip pressed into one.
#pragma once

#include "engine/contact/mesh/triangle_soup.h"
#include "engine/contact/proxy/analytic_shape.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/lab/rig/closest_point.h"
#include "engine/lab/rig/scenario/known_shapes.h"
#include "engine/scene/curved_patches.h"

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace springdrive::charts {

struct TouchTrial {
    std::string what; ///< "a sphere of 50 mm"
    std::vector<rig::PressedTip> tips;
    std::function<contact::TriangleSoup(int divisions)>
        mesh; ///< each division makes four triangles of one
    std::function<Vector3(const Vector3 &vertex_m)> normal; ///< exact normal; none: no curved mesh
    std::optional<contact::AnalyticShape> primitive;
};

/// Divisions for roughly 1,000 to 1,000,000 triangles.
inline constexpr int kCoarsestDivisions = 3;
inline constexpr int kFinestDivisions = 8;

[[nodiscard]] TouchTrial sphere_trial(std::size_t tips);
[[nodiscard]] TouchTrial organic_trial(std::size_t tips);
[[nodiscard]] TouchTrial thin_plate_trial(std::size_t tips);

/// A mesh with smooth shading as it is touched: curved by the exact normals at its vertices, and
/// subdivided until neighbouring facets differ by no more than half a degree, but into no more than
/// two million in total, as scenes are.
[[nodiscard]] contact::TriangleSoup bent(const contact::TriangleSoup &soup,
                                         const std::function<Vector3(const Vector3 &)> &normal);

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
