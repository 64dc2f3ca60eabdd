// Nearest points of segments and triangles, for distances to a surface.
#pragma once

#include "base/vector.h"

#include <array>

namespace springdrive::contact {

/// A point of a triangle by its barycentric weights, which show at which corner, on which edge or
/// where inside it lies: the point is Σ weightᵢ · cornerᵢ, no weight is negative and their sum is
/// 1.
struct TrianglePoint {
    Vector3 point_m{Vector3::Zero()};
    Vector3 weights{Vector3::Zero()};
};

/// The point of a triangle nearest to `to_m`. RT-safe.
[[nodiscard]] TrianglePoint nearest_on_triangle(const std::array<Vector3, 3> &corners_m,
                                                const Vector3 &to_m) noexcept;

/// The smallest distance between the segments a–b and c–d [m]; either may be a point. RT-safe.
[[nodiscard]] double segment_distance_m(const Vector3 &a_m, const Vector3 &b_m, const Vector3 &c_m,
                                        const Vector3 &d_m) noexcept;

} // namespace springdrive::contact
