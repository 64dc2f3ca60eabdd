// The triangles of a surface for independent checks of the proxy: geometry that shares no code with
// it.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/mesh_preparation.h"

#include <Eigen/Geometry>

#include <array>
#include <vector>

namespace springdrive::rig {

/// How far a point is from something, and the unit direction away from it.
struct Away {
    double distance_m = 0.0;
    Vector3 direction{Vector3::Zero()};
};

struct PlainTriangle {
    std::array<Vector3, 3> corners_m;
    Vector3 normal; ///< unit; corners turn counter-clockwise about it
    bool two_sided = false;

    [[nodiscard]] double height_m(const Vector3 &point_m) const {
        return normal.dot(point_m - corners_m[0]);
    }

    /// How far a point of its plane lies beyond an edge, or beyond the perpendicular at an end of
    /// the longest edge, the greatest of these; not positive inside. It is at most the distance
    /// from the triangle and at least half of it: the perpendiculars bound nothing that the edges
    /// do not, but beyond the tip of a needle both edges are as near as its angle is small, 5 pm at
    /// 10 nm from one of 0.06°.
    [[nodiscard]] double beyond_m(const Vector3 &point_m) const;

    /// From all of the triangle, whichever its side.
    [[nodiscard]] Away away(const Vector3 &point_m) const;

    [[nodiscard]] Eigen::AlignedBox3d bounds() const;

    /// The sine of the angle between its two shorter edges, by which round-off turns its normal
    /// the more the smaller it is.
    [[nodiscard]] double sine() const;
};

/// @param facets  as preparation left them: with an area
[[nodiscard]] std::vector<PlainTriangle>
plain_triangles(const std::vector<contact::FacetSource> &facets);

} // namespace springdrive::rig
