#include "app/demo/tip_inside.h"

#include "engine/contact/mesh/triangle_soup.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace springdrive::app {

namespace {

/// How often more a ray along a coordinate axis leaves the triangles than it enters them: 1 for a
/// point in a solid that is wound as glTF asks.
/// @param axis  along which, in the direction of `sign`
int exits(const contact::TriangleSoup &soup, const Vector3 &from_m, int axis, double sign) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    int count = 0;
    for (const auto &triangle : soup.triangles) {
        const std::array<const Vector3 *, 3> corner{&soup.vertices_m[triangle[0]],
                                                    &soup.vertices_m[triangle[1]],
                                                    &soup.vertices_m[triangle[2]]};
        // Twice the areas that the ray's foot makes with the edges, seen along the axis.
        std::array<double, 3> area{};
        for (std::size_t i = 0; i < 3; ++i) {
            const Vector3 &a = *corner[i];
            const Vector3 &b = *corner[(i + 1) % 3];
            area[i] =
                (a[u] - from_m[u]) * (b[v] - from_m[v]) - (a[v] - from_m[v]) * (b[u] - from_m[u]);
        }
        const bool is_hit = (area[0] > 0.0 && area[1] > 0.0 && area[2] > 0.0) ||
                            (area[0] < 0.0 && area[1] < 0.0 && area[2] < 0.0);
        if (!is_hit) {
            continue;
        }
        // Each area weighs the corner opposite to its edge.
        const double whole = area[0] + area[1] + area[2];
        const double where = (area[1] * (*corner[0])[axis] + area[2] * (*corner[1])[axis] +
                              area[0] * (*corner[2])[axis]) /
                             whole;
        if (sign * (where - from_m[axis]) > 0.0) {
            count += sign * whole > 0.0 ? 1 : -1;
        }
    }
    return count;
}

bool lies_in_mesh(const contact::TriangleSoup &soup, const Vector3 &point_m) {
    // No ray runs along edges, which lie at round numbers in many scenes: less than the clearance
    // of the proxy beside them.
    const Vector3 beside_m = point_m + Vector3(1.3e-7, 2.9e-7, 1.9e-7);
    for (int axis = 0; axis < 3; ++axis) {
        for (const double sign : {1.0, -1.0}) {
            if (exits(soup, beside_m, axis, sign) < 1) {
                return false; // an open mesh is open in some direction
            }
        }
    }
    return true;
}

} // namespace

bool lies_inside(const scene::Scene &scene, const Vector3 &point_m) {
    const bool is_in_shape =
        std::ranges::any_of(scene.shapes, [&](const contact::AnalyticShape &shape) {
            return shape.is_solid() && shape.nearest(point_m).distance_m < 0.0;
        });
    const bool may_be_in_mesh = (point_m.array() > scene.lower_m.array()).all() &&
                                (point_m.array() < scene.upper_m.array()).all();
    return is_in_shape || (may_be_in_mesh && lies_in_mesh(scene.surface, point_m));
}

bool TipInside::at(const scene::Scene &scene, std::uint32_t scene_id, const Vector3 &tip_m,
                   double time_s) {
    constexpr double kPause_s = 0.25;
    constexpr double kMoved_m = 1e-4; // a few encoder counts
    const bool is_due = scene_id != scene_id_ || !next_s_ ||
                        (time_s >= *next_s_ && !((tip_m - tip_m_).norm() < kMoved_m));
    if (is_due) {
        is_inside_ = tip_m.allFinite() && lies_inside(scene, tip_m);
        scene_id_ = scene_id;
        tip_m_ = tip_m;
        next_s_ = time_s + kPause_s;
    }
    return is_inside_;
}

} // namespace springdrive::app
