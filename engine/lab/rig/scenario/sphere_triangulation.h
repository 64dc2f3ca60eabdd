// A Delaunay triangulation of points on the unit sphere that grows by one point at a time.
#pragma once

#include "base/vector.h"

#include <array>
#include <cstdint>
#include <vector>

namespace springdrive::rig {

class SphereTriangulation {
public:
    using Triangle = std::array<std::uint32_t, 3>;

    /// The regular octahedron.
    SphereTriangulation();

    /// Divides a triangle into three at a direction within it, then flips edges until no
    /// circumscribed circle contains a point. The result holds, until the next call, the triangles
    /// that changed, new ones included, some of them more than once.
    /// @pre `direction` is of length 1, strictly within the triangle as seen from the origin
    const std::vector<std::uint32_t> &insert(std::uint32_t triangle, const Vector3 &direction);

    [[nodiscard]] const std::vector<Vector3> &points() const { return points_; }
    /// Wound counter-clockwise seen from outside.
    [[nodiscard]] const std::vector<Triangle> &triangles() const { return triangles_; }

private:
    void replace_neighbour(std::uint32_t of, std::uint32_t old, std::uint32_t replacement);
    [[nodiscard]] bool is_within_circle(std::uint32_t triangle, std::uint32_t point) const;
    void flip_first_edge(std::uint32_t triangle, std::uint32_t other, std::size_t opposite);

    std::vector<Vector3> points_;
    std::vector<Triangle> triangles_;
    std::vector<Triangle> neighbours_; ///< across the edge opposite to each corner
    std::vector<std::uint32_t> unchecked_;
    std::vector<std::uint32_t> changed_;
};

} // namespace springdrive::rig
