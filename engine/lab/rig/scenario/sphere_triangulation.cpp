#include "engine/lab/rig/scenario/sphere_triangulation.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cstddef>

namespace springdrive::rig {

namespace {

/// Points on one circle to round-off are left as they are: u for coordinates up to 1, with some
/// margin, so that no edge is flipped back and forth.
constexpr double kRoundOff = 1e-15;

} // namespace

SphereTriangulation::SphereTriangulation()
    : points_{Vector3::UnitX(),  Vector3::UnitY(),  Vector3::UnitZ(),
              -Vector3::UnitX(), -Vector3::UnitY(), -Vector3::UnitZ()},
      triangles_{{0, 1, 2}, {1, 3, 2}, {3, 4, 2}, {4, 0, 2},
                 {1, 0, 5}, {3, 1, 5}, {4, 3, 5}, {0, 4, 5}},
      neighbours_{{1, 3, 4}, {2, 0, 5}, {3, 1, 6}, {0, 2, 7},
                  {7, 5, 0}, {4, 6, 1}, {5, 7, 2}, {6, 4, 3}} {}

const std::vector<std::uint32_t> &SphereTriangulation::insert(std::uint32_t triangle,
                                                              const Vector3 &direction) {
    const auto p = static_cast<std::uint32_t>(points_.size());
    const auto second = static_cast<std::uint32_t>(triangles_.size());
    const std::uint32_t third = second + 1;
    const auto [a, b, c] = triangles_[triangle];
    const auto [across_bc, across_ca, across_ab] = neighbours_[triangle];
    points_.push_back(direction);
    triangles_[triangle] = {p, b, c};
    neighbours_[triangle] = {across_bc, second, third};
    triangles_.insert(triangles_.end(), {{p, c, a}, {p, a, b}});
    neighbours_.insert(neighbours_.end(),
                       {{across_ca, third, triangle}, {across_ab, triangle, second}});
    replace_neighbour(across_ca, triangle, second);
    replace_neighbour(across_ab, triangle, third);

    // Lawson's flips: only edges opposite to the new point can be wrong.
    unchecked_ = changed_ = {triangle, second, third};
    while (!unchecked_.empty()) {
        const std::uint32_t checked = unchecked_.back();
        unchecked_.pop_back();
        const std::uint32_t other = neighbours_[checked][0];
        const auto opposite = static_cast<std::size_t>(
            std::ranges::find(neighbours_[other], checked) - neighbours_[other].begin());
        if (is_within_circle(checked, triangles_[other][opposite])) {
            flip_first_edge(checked, other, opposite);
            unchecked_.insert(unchecked_.end(), {checked, other});
            changed_.push_back(other);
        }
    }
    return changed_;
}

void SphereTriangulation::replace_neighbour(std::uint32_t of, std::uint32_t old,
                                            std::uint32_t replacement) {
    std::ranges::replace(neighbours_[of], old, replacement);
}

/// On a sphere the circle is cut off by the triangle's plane.
bool SphereTriangulation::is_within_circle(std::uint32_t triangle, std::uint32_t point) const {
    const auto &[a, b, c] = triangles_[triangle];
    const Vector3 &from = points_[a];
    return (points_[b] - from).cross(points_[c] - from).dot(points_[point] - from) >
           kRoundOff * (points_[b] - from).norm() * (points_[c] - from).norm();
}

/// Two triangles (p, b, c) and (d, c, b) become (p, b, d) and (p, d, c).
void SphereTriangulation::flip_first_edge(std::uint32_t triangle, std::uint32_t other,
                                          std::size_t opposite) {
    const auto [p, b, c] = triangles_[triangle];
    const std::uint32_t d = triangles_[other][opposite];
    const std::uint32_t across_cp = neighbours_[triangle][1];
    const std::uint32_t across_pb = neighbours_[triangle][2];
    const std::uint32_t across_bd = neighbours_[other][(opposite + 1) % 3];
    const std::uint32_t across_dc = neighbours_[other][(opposite + 2) % 3];
    triangles_[triangle] = {p, b, d};
    neighbours_[triangle] = {across_bd, other, across_pb};
    triangles_[other] = {p, d, c};
    neighbours_[other] = {across_dc, across_cp, triangle};
    replace_neighbour(across_bd, other, triangle);
    replace_neighbour(across_cp, triangle, other);
}

} // namespace springdrive::rig
