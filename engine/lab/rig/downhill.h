// A slow and plain answer to the proxy's question: how far down the distance to the tip can one get
// from here without coming too near to a triangle or shape?
#pragma once

#include "base/vector.h"
#include "engine/contact/proxy/analytic_shape.h"
#include "engine/lab/rig/plain_triangles.h"

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace springdrive::rig {

/// Of `wish`, the nearest vector that goes against none of the pushes: its projection onto the cone
/// { v : nᵢ · v >= 0 }, found by trying all faces of the cone.
/// @param pushes  unit
[[nodiscard]] Vector3 unopposed_part(const Vector3 &wish, std::span<const Vector3> pushes);

/// By how much a walk downhill may come nearer than the reach [m]: far above round-off. Ridges
/// lower than that do not hold it.
inline constexpr double kLeastSlack_m = 2e-12;

class Downhill {
public:
    /// Triangles and shapes must outlive this.
    /// @param slack_m  at least kLeastSlack_m
    explicit Downhill(std::span<const PlainTriangle> triangles,
                      std::span<const contact::AnalyticShape> shapes = {},
                      double slack_m = kLeastSlack_m);

    struct End {
        Vector3 point_m{Vector3::Zero()};
        bool is_lowest = false; ///< nothing nearer can be reached from there; false: gave up
    };

    /// Walks down in straight steps of 50 µm at most, each as far as every triangle and shape
    /// allows. They are convex, and so is the distance to each along a line: Newton's method, from
    /// the start of a step on, never goes beyond the place where one is too near.
    ///
    /// A step is blocked by what it would come nearer to than the reach, less the slack; not by
    /// what is merely near: over a flat edge the next triangle's rim lies as near as the own plane,
    /// at any slant, and stops nothing. The way then goes on along what blocks.
    ///
    /// Ends where less than 1 nm, or 0.2 µrad seen from the target, is left to go.
    /// @param reach_m  what to keep from all of them; what starts nearer comes no nearer
    [[nodiscard]] End walk(const Vector3 &from_m, const Vector3 &target_m, double reach_m) const;

private:
    struct Ball {
        Vector3 centre_m;
        double radius_m;
    };

    /// Of a straight motion: how far it may go, and what for it may not go on.
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
    std::vector<Ball> balls_; ///< about each triangle
};

} // namespace springdrive::rig
