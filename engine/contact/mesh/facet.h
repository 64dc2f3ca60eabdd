// One touchable triangle, prepared for the question that the proxy asks all the time: how far may a
// straight motion go before it comes too near?
//
// "Too near" is nearer than the proxy's reach, its radius, to any point of the triangle: a true
// offset, with round edges and corners. So no motion slips through the round-off between two
// triangles or through a crack narrower than twice the reach, and what may be done in a place
// follows from the planes that touch there, in whatever order they were met.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/nearest.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

namespace springdrive::contact {

/// The least reach [m], that of a proxy without a radius: 10 nm, far below what an encoder
/// resolves or a hand feels, far above round-off.
inline constexpr double kClearance_m = 1e-8;

/// A motion may come nearer than the reach by this much [m]: far above round-off, so that what
/// slides along one plane is not held up by the next in line.
inline constexpr double kSlack_m = 1e-12;

/// What arithmetic leaves of a distance within a metre [m].
inline constexpr double kRoundOff_m = 1e-15;

/// What has lost less than this of its reach is given it back [m]; what has lost more started too
/// near, and keeps what it has.
inline constexpr double kLostByRoundOff_m = 1e-10;

/// What is no farther than this from touching touches [m]. Round a reach of 10 nm a picometre more
/// would be a slant of a degree, and a rim beside the way would hold what it does not touch; so
/// this is what arithmetic leaves at that place, and no more.
[[nodiscard]] inline double touching_within_m(const Vector3 &point_m) noexcept {
    return 2e-15 * (1.0 + point_m.cwiseAbs().maxCoeff());
}

enum class FacetSides : std::uint8_t {
    one, ///< bounds a volume: stops what comes from the side its normal points to
    two, ///< a sheet: stops what comes from either side
};

/// What a facet is made from.
struct FacetSource {
    std::array<Vector3, 3> corners_m;
    FacetSides sides = FacetSides::one;
    std::uint32_t triangle = 0; ///< its index in the soup
    std::uint16_t material = 0; ///< index into the soup's
};

/// Smallest of a triangle's three heights [m]; zero if it has no area.
[[nodiscard]] double smallest_height_m(const std::array<Vector3, 3> &corners_m) noexcept;

/// How far a motion may go, and the half-space  normal · x >= offset_m  to stay in from there on:
/// it touches the obstacle's offset where the motion ends, and holds none of its inside.
struct Stop {
    double fraction = 0.0;
    Vector3 normal{Vector3::Zero()};
    double offset_m = 0.0;
};

/// On two cache lines of its own; most motions need but the first, with the plane.
class alignas(64) Facet {
public:
    /// @pre smallest_height_m(source.corners_m) is above round-off
    explicit Facet(const FacetSource &source) noexcept;

    /// What stops the motion from `from_m` to `to_m`, if anything does. What starts too near
    /// already may not come nearer. Motions that start behind a one-sided facet are let through.
    /// RT-safe.
    [[nodiscard]] std::optional<Stop> stop(const Vector3 &from_m, const Vector3 &to_m,
                                           double reach_m) const noexcept;

    /// The plane that touches the offset above a point, if the point is no farther than `within_m`
    /// from the offset, and on a side from which the facet can be touched. RT-safe.
    [[nodiscard]] std::optional<Stop> touch(const Vector3 &point_m, double reach_m,
                                            double within_m) const noexcept;

    /// The point of the triangle nearest to `point_m`. RT-safe.
    [[nodiscard]] TrianglePoint nearest(const Vector3 &point_m) const noexcept {
        return nearest_on_triangle(corners_m_, point_m);
    }

    /// Whether the foot of a point on the facet's plane lies in the triangle. RT-safe.
    [[nodiscard]] bool is_over(const Vector3 &point_m) const noexcept;

    /// Unit; counter-clockwise winding turns about it.
    [[nodiscard]] const Vector3 &normal() const noexcept { return normal_; }

    /// Of the facet's plane  normal · x = offset  [m].
    [[nodiscard]] double offset_m() const noexcept { return offset_m_; }

    /// Above the plane of the facet, on the side of the normal [m].
    [[nodiscard]] double height_m(const Vector3 &point_m) const noexcept {
        return normal_.dot(point_m) - offset_m_;
    }

    [[nodiscard]] FacetSides sides() const noexcept { return sides_; }
    [[nodiscard]] std::uint32_t triangle() const noexcept { return triangle_; }
    [[nodiscard]] std::uint16_t material() const noexcept { return material_; }

private:
    struct Crossing;
    [[nodiscard]] std::optional<Stop> stop_at_rim(const Crossing &crossing) const noexcept;
    [[nodiscard]] Stop plane_above(double fraction, double side, double kept_m) const noexcept {
        return {fraction, side * normal_, side * offset_m_ + kept_m};
    }

    Vector3 normal_;
    double offset_m_;
    std::array<Vector3, 3> corners_m_; ///< read last: most motions pass the plane
    std::uint32_t triangle_;
    std::uint16_t material_;
    FacetSides sides_;
};

/// What a proxy keeps that is `distance_m` away: its reach, unless it started nearer than that.
[[nodiscard]] inline double kept_distance_m(double distance_m, double reach_m) noexcept {
    return distance_m > reach_m - kLostByRoundOff_m ? reach_m : distance_m;
}

/// How near a motion may then come: what had to start too near gets no slack, or a slow one would
/// use it up over and over.
[[nodiscard]] inline double nearest_allowed_m(double kept_m, double reach_m) noexcept {
    return kept_m < reach_m ? kept_m - kRoundOff_m : reach_m - kSlack_m;
}

/// Advances a motion towards a convex obstacle, from one supporting plane to the next, until it
/// touches: `nearest(point)` is the obstacle's nearest point to it, and `nearest_m` that to where
/// the motion starts. Every plane parts the obstacle from all of the motion that was passed, so
/// nothing is stepped over. RT-safe.
template <typename Nearest>
[[nodiscard]] std::optional<Stop>
advance_to_touch(const Vector3 &from_m, const Vector3 &to_m, double start_fraction,
                 Vector3 nearest_m, double reach_m, const Nearest &nearest) noexcept {
    // Quadratic towards what it meets squarely; what it grazes halves the rest of the way in each
    // step, and after 64 of those no way is left.
    constexpr int kSteps = 64;
    const double touching_m = 0.5 * touching_within_m(from_m);
    const Vector3 motion = to_m - from_m;
    double fraction = start_fraction;
    double kept_m = reach_m;
    Vector3 at_m = from_m + fraction * motion;
    Stop stop;
    for (int step = 0; step < kSteps; ++step) {
        const Vector3 gap = at_m - nearest_m;
        const double distance_m = gap.norm();
        if (distance_m == 0.0) {
            return std::nullopt; // in the obstacle: there is no way to keep out of it
        }
        if (step == 0) {
            kept_m = kept_distance_m(distance_m, reach_m);
        }
        stop = {fraction, gap / distance_m, 0.0};
        const double clear_m = stop.normal.dot(to_m - nearest_m);
        stop.offset_m = stop.normal.dot(nearest_m) + kept_m;
        if (clear_m >= std::min(nearest_allowed_m(kept_m, reach_m), distance_m)) {
            return std::nullopt;
        }
        if (distance_m <= kept_m + touching_m) {
            return stop;
        }
        fraction += (1.0 - fraction) * (distance_m - kept_m) / (distance_m - clear_m);
        at_m = from_m + fraction * motion;
        nearest_m = nearest(at_m);
    }
    return stop;
}

} // namespace springdrive::contact
