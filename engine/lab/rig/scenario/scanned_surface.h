// A surface as a range scanner measures it: points at random, noise, holes.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/triangle_soup.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace springdrive::rig {

/// A Delaunay triangulation of points on the unit sphere that grows by one point at a time.
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

/// A cone from the origin in which nothing was measured; its rim in the mesh is ragged.
struct ScanHole {
    Vector3 direction;
    double half_angle_rad;
};

/// By how much the rim of a hole may lie outside its cone.
inline constexpr double kMaxRaggedness_rad = 0.02;

/// The body of `organic_shape`, `kTestOrganicScale_m` times its size, measured from outside: about
/// that many triangles between points at random, ten times as dense in some parts as in others;
/// noise of 20 µm (rms) at wavelengths from 8 mm to 0.13 mm; one triangle in 200 a sliver of 1 : 10
/// to 1 : 1000. Open below and at the holes, wound outwards, vertices shared. No ray from the
/// origin meets it twice. The same for the same arguments.
[[nodiscard]] contact::TriangleSoup scanned_surface(std::size_t triangles, std::uint64_t seed);

/// Those of that seed: the open underside first, then 20 of 0.2 to 2 mm in radius.
[[nodiscard]] std::vector<ScanHole> scan_holes(std::uint64_t seed);

/// How far the body is from the origin in a direction of length 1, without noise and holes.
[[nodiscard]] double scanned_body_radius_m(const Vector3 &direction);

} // namespace springdrive::rig
