// An independent, slow solution of the proxy's problem: how far can the distance to the tip be
// reduced from here without coming too close to a triangle or shape?
#pragma once

#include "base/vector.h"
#include "engine/contact/proxy/analytic_shape.h"
#include "engine/lab/rig/plain_triangles.h"

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace springdrive::rig {

/// Of `desired`, the nearest vector that opposes none of the pushes: its projection onto the cone
/// { v : nᵢ · v >= 0 }, found by trying all faces of the cone.
/// @param pushes  unit
[[nodiscard]] Vector3 unopposed_part(const Vector3 &desired, std::span<const Vector3> pushes);

/// By how much a descent may come closer than the reach [m]: far above round-off. Ridges lower than
/// this do not stop it.
inline constexpr double kMinSlack_m = 2e-12;

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
