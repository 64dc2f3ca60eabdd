// An independent, slow solution of the proxy's problem: how far can the distance to the tip be
// reduced from here without coming too close to a triangle or shape? Geometry and search share no
// code with the proxy.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/mesh_preparation.h"
#include "engine/contact/proxy/analytic_shape.h"

#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
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

/// Whether a straight motion goes through a triangle: of a closed surface from its front, of an
/// open one from either side. A motion that passes the rim by less than 0.1 nm counts as one
/// through it, so that no motion between two triangles is missed; by more if round-off may shift
/// the crossing by more, but not by 5 nm, half of what the proxy keeps.
[[nodiscard]] bool goes_through(const PlainTriangle &triangle, const Vector3 &from_m,
                                const Vector3 &to_m);

/// A binary tree of boxes about triangles, halved at the median of the triangles' middles.
class NearbyTriangles {
public:
    /// @param triangles  must outlive this
    explicit NearbyTriangles(std::span<const PlainTriangle> triangles);

    /// The triangles whose boxes are no farther than `radius_m` from a point, by ascending index.
    [[nodiscard]] std::vector<std::size_t> within(const Vector3 &centre_m, double radius_m) const;

    /// A triangle that a straight motion goes through, if there is one.
    [[nodiscard]] std::optional<std::size_t> crossed(const Vector3 &from_m,
                                                     const Vector3 &to_m) const;

private:
    struct Node {
        Eigen::AlignedBox3d box;
        std::uint32_t first = 0; ///< of its triangles in `order_`
        std::uint32_t last = 0;  ///< one beyond
        std::uint32_t other = 0; ///< its second half; the first follows it. 0: not halved
    };

    std::uint32_t add(std::uint32_t first, std::uint32_t last,
                      const std::vector<Vector3> &middles_m);

    /// Calls `visit(index)` for each triangle whose box satisfies `is_near`, until it returns true.
    template <typename IsNear, typename Visit>
    void search(const IsNear &is_near, const Visit &visit) const;

    std::span<const PlainTriangle> triangles_;
    std::vector<std::uint32_t> order_; ///< indices of triangles
    std::vector<Node> nodes_;
};

/// Of `desired`, the nearest vector that opposes none of the pushes: its projection onto the cone
/// { v : nᵢ · v >= 0 }, found by trying all faces of the cone.
/// @param pushes  unit
[[nodiscard]] Vector3 unopposed_part(const Vector3 &desired, std::span<const Vector3> pushes);

/// By how much a descent may come closer than the reach [m]: far above round-off. Ridges lower than
/// this do not stop it.
inline constexpr double kMinSlack_m = 2e-12;

/// Ridges lower than this must not hold a proxy [m]: a hundredth of what the device resolves.
inline constexpr double kHop_m = 3e-7;

class BruteForceProxy {
public:
    /// Triangles and shapes must outlive this.
    /// @param slack_m  at least kMinSlack_m
    explicit BruteForceProxy(std::span<const PlainTriangle> triangles,
                             std::span<const contact::AnalyticShape> shapes = {},
                             double slack_m = kMinSlack_m);

    [[nodiscard]] const NearbyTriangles &nearby() const { return nearby_; }

    struct End {
        Vector3 point_m{Vector3::Zero()};
        bool is_lowest =
            false; ///< nothing nearer can be reached from there; false: step limit reached
    };

    /// Descends in straight steps of at most 50 µm, each as far as every triangle and shape
    /// allows. They are convex, and so is the distance to each along a line: Newton's method, from
    /// the start of a step on, never passes the point at which one is too close.
    ///
    /// A step is blocked by what it would approach closer than the reach minus the slack, not by
    /// what is merely close: at a flat edge the next triangle's rim is as close as the own plane,
    /// at any slant, and blocks nothing. The descent then continues along what blocks.
    ///
    /// Ends where less than 1 nm, or 0.2 µrad seen from the target, remains.
    /// @param reach_m  distance to keep from all of them; what starts closer comes no closer
    [[nodiscard]] End walk(const Vector3 &from_m, const Vector3 &target_m, double reach_m) const;

    /// Where a hop leads on: away from the target by up to kHop_m, as far as that is free, then
    /// sideways by kHop_m, in 32 directions, and from there as `walk` does; all of it at the full
    /// reach, but for the slack. The nearest end, if it is nearer than `from_m` by more than
    /// kHop_m.
    /// @pre `from_m` is not the target
    [[nodiscard]] std::optional<Vector3> hop(const Vector3 &from_m, const Vector3 &target_m,
                                             double reach_m) const;

private:
    /// Of a straight motion: how far it may go, and what stops it.
    struct Free {
        double length_m = 0.0;
        std::optional<std::size_t> blocked_by;
    };

    /// Triangles by their indices, then shapes.
    [[nodiscard]] std::vector<std::size_t> within(const Vector3 &centre_m, double radius_m) const;
    [[nodiscard]] bool stops_what_is_at(std::size_t obstacle, const Vector3 &point_m) const;
    [[nodiscard]] Away away(std::size_t obstacle, const Vector3 &point_m) const;
    [[nodiscard]] double length_until_m(std::size_t obstacle, double level_m, const Vector3 &from_m,
                                        const Vector3 &direction, double length_m) const;
    [[nodiscard]] Free free_way(const std::vector<std::size_t> &listed, const Vector3 &from_m,
                                const Vector3 &direction, double length_m, double reach_m) const;
    [[nodiscard]] bool step(const std::vector<std::size_t> &listed, const Vector3 &target_m,
                            double reach_m, End &end) const;

    std::span<const PlainTriangle> triangles_;
    std::span<const contact::AnalyticShape> shapes_;
    double slack_m_;
    NearbyTriangles nearby_;
};

} // namespace springdrive::rig
