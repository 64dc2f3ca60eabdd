#include "engine/contact/mesh/nearest.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace springdrive::contact {

namespace {

/// Where on a–b, from 0 to 1, the point nearest to p lies.
[[nodiscard]] double nearest_share(const Vector3 &a_m, const Vector3 &b_m,
                                   const Vector3 &p_m) noexcept {
    const Vector3 along = b_m - a_m;
    const double length2 = along.squaredNorm();
    return length2 > 0.0 ? std::clamp((p_m - a_m).dot(along) / length2, 0.0, 1.0) : 0.0;
}

} // namespace

TrianglePoint nearest_on_triangle(const std::array<Vector3, 3> &corners_m,
                                  const Vector3 &to_m) noexcept {
    // Inside all three edges: the foot on the plane, from the areas of the three triangles that it
    // forms.
    const Vector3 area =
        (corners_m[1] - corners_m[0]).cross(corners_m[2] - corners_m[0]); // twice, along the normal
    const double area2 = area.squaredNorm();
    std::array<double, 3> parts{};
    bool is_inside = area2 > 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        const Vector3 &from = corners_m[(i + 1) % 3];
        parts[i] = (corners_m[(i + 2) % 3] - from).cross(to_m - from).dot(area);
        is_inside = is_inside && parts[i] >= 0.0;
    }
    TrianglePoint nearest;
    if (is_inside) {
        const double sum = parts[0] + parts[1] + parts[2];
        nearest.weights = Vector3(parts[0], parts[1], parts[2]) / sum;
        const Vector3 normal = area / std::sqrt(area2);
        nearest.point_m = to_m - normal.dot(to_m - corners_m[0]) * normal;
        return nearest;
    }
    double min2 = -1.0;
    for (std::size_t i = 0; i < 3; ++i) {
        // The nearest point is on an edge only if the foot lies outside of that edge.
        if (parts[i] > 0.0) {
            continue;
        }
        const std::size_t j = (i + 1) % 3;
        const std::size_t k = (i + 2) % 3;
        const double share = nearest_share(corners_m[j], corners_m[k], to_m);
        const Vector3 point = corners_m[j] + share * (corners_m[k] - corners_m[j]);
        const double distance2 = (to_m - point).squaredNorm();
        if (min2 < 0.0 || distance2 < min2) {
            min2 = distance2;
            nearest.point_m = point;
            nearest.weights.setZero();
            nearest.weights[static_cast<Eigen::Index>(j)] = 1.0 - share;
            nearest.weights[static_cast<Eigen::Index>(k)] = share;
        }
    }
    return nearest;
}

double segment_distance_m(const Vector3 &a_m, const Vector3 &b_m, const Vector3 &c_m,
                          const Vector3 &d_m) noexcept {
    const Vector3 u = b_m - a_m;
    const Vector3 v = d_m - c_m;
    const Vector3 w = a_m - c_m;
    const double uu = u.squaredNorm();
    const double vv = v.squaredNorm();
    const double uv = u.dot(v);
    const double determinant = u.cross(v).squaredNorm(); // uu vv − uv², without cancellation
    // The nearest pair includes an end point, unless both points lie inside their segments: then
    // they are where the lines come nearest.
    double min2 = std::min({(a_m - c_m - nearest_share(c_m, d_m, a_m) * v).squaredNorm(),
                            (b_m - c_m - nearest_share(c_m, d_m, b_m) * v).squaredNorm(),
                            (c_m - a_m - nearest_share(a_m, b_m, c_m) * u).squaredNorm(),
                            (d_m - a_m - nearest_share(a_m, b_m, d_m) * u).squaredNorm()});
    if (determinant > 0.0) {
        const double s = (uv * v.dot(w) - vv * u.dot(w)) / determinant;
        const double t = (uu * v.dot(w) - uv * u.dot(w)) / determinant;
        if (s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0) {
            min2 = std::min(min2, (w + s * u - t * v).squaredNorm());
        }
    }
    return std::sqrt(min2);
}

} // namespace springdrive::contact
