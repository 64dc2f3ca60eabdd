// The shapes on which rendering methods are tried, each as meshes of any fineness and, where one
// exists, as a primitive.
#pragma once

#include "engine/contact/mesh/triangle_soup.h"
#include "engine/contact/proxy/analytic_shape.h"
#include "engine/lab/rig/scenario/pressed_tips.h"
#include "engine/scene/patch_edges.h"

#include <functional>
#include <optional>
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

} // namespace springdrive::charts
