// One touchable triangle, prepared for the proxy's most frequent query: how far may a straight
// motion go before it comes too near?
//
// "Too near" is nearer than the proxy's reach, its radius, to any point of the triangle: a true
// offset, with round edges and corners. So no motion slips through the round-off between two
// triangles or through a crack narrower than twice the reach, and the motions allowed at a place
// follow from the planes that touch there, whatever the order in which they were found.
#pragma once

#include "base/vector.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace springdrive::contact {

// Nearest points of segments and triangles, for distances to a surface.

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

/// The minimum reach [m], that of a proxy without a radius: 10 nm, far below what an encoder
/// resolves or a hand perceives, far above round-off.
inline constexpr double kClearance_m = 1e-8;

/// A motion may come nearer than the reach by this much [m]: far above round-off, so that a slide
/// along one plane is not stopped by the next coplanar one.
inline constexpr double kSlack_m = 1e-12;

/// Round-off of a distance computed within a metre of the origin [m].
inline constexpr double kRoundOff_m = 1e-15;

/// A proxy that has lost less than this of its reach is restored to it [m]; one that has lost more
/// started too near, and keeps its present distance.
inline constexpr double kLostByRoundOff_m = 1e-10;

/// What is no farther than this from touching counts as touching [m]. With a reach of 10 nm, a
/// picometre more would tilt the plane by a degree, and a rim beside the path would hold a proxy
/// that it does not touch; so this is the round-off at that place and no more.
[[nodiscard]] inline double touching_within_m(const Vector3 &point_m) noexcept {
    return 2e-15 * (1.0 + point_m.cwiseAbs().maxCoeff());
}

enum class FacetSides : std::uint8_t {
    one, ///< bounds a volume: stops motions from the side its normal points to
    two, ///< a sheet: stops motions from either side
};

/// What a facet is constructed from.
struct FacetSource {
    std::array<Vector3, 3> corners_m;
    FacetSides sides = FacetSides::one;
    std::uint32_t triangle = 0; ///< its index in the soup
    std::uint16_t material = 0; ///< index into the soup's
    bool is_crowded = false;    ///< many others share a vertex with it
};

/// Smallest of a triangle's three heights [m]; zero if it has no area.
[[nodiscard]] double min_height_m(const std::array<Vector3, 3> &corners_m) noexcept;

/// How far a motion may go, and the half-space normal · x >= offset_m to stay in from there on: it
/// touches the obstacle's offset where the motion ends, and excludes all of its inside.
struct Stop {
    double fraction = 0.0;
    Vector3 normal{Vector3::Zero()}; ///< zero: it is not known whether anything is there
    double offset_m = 0.0;
};

/// What the parts of a search take, in the unit of a SearchBudget: a look at a facet's plane, at
/// the nearest point of it, as in each step towards it, and how near a motion comes to its edges.
/// Measured with facets that are not in the cache.
inline constexpr int kFacetEffort = 1;
inline constexpr int kNearestEffort = 12;
inline constexpr int kGrazingEffort = 12;

/// On two cache lines of its own; most motions need only the first, with the plane.
class alignas(64) Facet {
public:
    /// @pre min_height_m(source.corners_m) is above round-off
    explicit Facet(const FacetSource &source) noexcept;

    /// Where the facet stops the motion from `from_m` to `to_m`, if it does. A motion that starts
    /// too near may not come nearer. Motions that start behind a one-sided facet pass. RT-safe.
    /// @param last_fraction  of the motion that is of interest: a later stop may be missed
    /// @param effort_left  is reduced by what this takes; where none is left, a motion near the rim
    ///                     ends unknown where it comes within reach of the facet's plane
    [[nodiscard]] std::optional<Stop> stop(const Vector3 &from_m, const Vector3 &to_m,
                                           double reach_m, double last_fraction,
                                           int &effort_left) const noexcept;

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

    [[nodiscard]] const std::array<Vector3, 3> &corners_m() const noexcept { return corners_m_; }

    [[nodiscard]] FacetSides sides() const noexcept { return sides_; }
    [[nodiscard]] std::uint32_t triangle() const noexcept { return triangle_; }
    [[nodiscard]] std::uint16_t material() const noexcept { return material_; }

private:
    struct Crossing;
    [[nodiscard]] std::optional<Stop> stop_at_rim(const Crossing &crossing,
                                                  int &effort_left) const noexcept;
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

/// The distance that a proxy at `distance_m` keeps: its reach, unless it started nearer than that.
[[nodiscard]] inline double kept_distance_m(double distance_m, double reach_m) noexcept {
    return distance_m > reach_m - kLostByRoundOff_m ? reach_m : distance_m;
}

/// How near a motion may then come: one that started too near gets no slack, or a slow motion would
/// use it up again in every step.
[[nodiscard]] inline double nearest_allowed_m(double kept_m, double reach_m) noexcept {
    return kept_m < reach_m ? kept_m - kRoundOff_m : reach_m - kSlack_m;
}

/// Whether the plane between a convex obstacle and the start of a motion keeps all of the motion
/// far enough from the obstacle.
/// @param nearest_m  the obstacle's point nearest to the start
[[nodiscard]] inline bool is_parted(const Vector3 &from_m, const Vector3 &to_m,
                                    const Vector3 &nearest_m, double reach_m) noexcept {
    const Vector3 gap = from_m - nearest_m;
    const double distance_m = gap.norm();
    const double kept_m = kept_distance_m(distance_m, reach_m);
    return gap.dot(to_m - nearest_m) >=
           distance_m * std::min(nearest_allowed_m(kept_m, reach_m), distance_m);
}

/// Advances a motion towards a convex obstacle, from one supporting plane to the next, until it
/// touches (conservative advancement): `nearest(point)` is the obstacle's nearest point to it, and
/// `nearest_m` that to where the motion starts. Every plane separates the obstacle from the part of
/// the motion already passed, so nothing is stepped over. A stop beyond `last_fraction` may be
/// missed. RT-safe.
template <typename Nearest>
[[nodiscard]] std::optional<Stop> advance_to_touch(const Vector3 &from_m, const Vector3 &to_m,
                                                   double start_fraction, Vector3 nearest_m,
                                                   double reach_m, double last_fraction,
                                                   const Nearest &nearest) noexcept {
    // Converges quadratically in a head-on approach; a grazing one halves the remaining motion in
    // each step, and after 64 steps nothing remains.
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
            return std::nullopt; // inside the obstacle: there is no direction to keep out of it
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
        if (fraction > last_fraction) {
            return std::nullopt;
        }
        at_m = from_m + fraction * motion;
        nearest_m = nearest(at_m);
    }
    return stop;
}

// The boxes by which a search finds facets.
//
// The box of a long thin facet that lies obliquely, or of one of many at a vertex, holds little of
// it and much of its neighbours: near such facets a search would look at hundreds. Those are cut
// into pieces, each with a box of its own. The facets themselves stay whole.

struct FacetBoxes {
    std::vector<Eigen::AlignedBox3d> boxes_m;
    std::vector<std::uint32_t> facet_of_box;
};

/// At most this many boxes more than facets: they take 32 bytes and some microseconds each.
inline constexpr std::size_t kMaxMoreBoxes = 500'000;

/// At least one box for each facet; the boxes of a facet cover it.
[[nodiscard]] FacetBoxes boxes_of(const std::vector<FacetSource> &facets);

} // namespace springdrive::contact
