#include "engine/contact/mesh/facet.h"

#include "base/assertions.h"
#include "base/cancellation.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <queue>
#include <utility>

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

namespace {

/// The two edges that meet at the widest angle, which are all but the longest, give the normal with
/// the least cancellation.
[[nodiscard]] Vector3 area_vector(const std::array<Vector3, 3> &corners_m) noexcept {
    std::size_t apex = 0;
    double longest = -1.0;
    for (std::size_t i = 0; i < 3; ++i) {
        const double opposite = (corners_m[(i + 2) % 3] - corners_m[(i + 1) % 3]).squaredNorm();
        if (opposite > longest) {
            longest = opposite;
            apex = i;
        }
    }
    const Vector3 to_next = corners_m[(apex + 1) % 3] - corners_m[apex];
    const Vector3 to_last = corners_m[(apex + 2) % 3] - corners_m[apex];
    return to_next.cross(to_last);
}

/// An edge's direction away from the triangle, in its plane, as long as the edge.
[[nodiscard]] Vector3 outward(std::size_t edge, const std::array<Vector3, 3> &corners_m,
                              const Vector3 &normal) noexcept {
    return (corners_m[(edge + 1) % 3] - corners_m[edge]).cross(normal);
}

} // namespace

/// A motion that passes through the layer within reach of the facet's plane.
struct Facet::Crossing {
    const Vector3 &from_m;
    const Vector3 &to_m;
    double reach_m;
    double last_fraction;
    double enters; ///< fraction of the motion where it enters the layer
    Vector3 enters_m;
    Vector3 leaves_m;
    bool pierces; ///< the triangle, or ends in the layer over it
};

double min_height_m(const std::array<Vector3, 3> &corners_m) noexcept {
    const double longest = std::sqrt(std::max({(corners_m[1] - corners_m[0]).squaredNorm(),
                                               (corners_m[2] - corners_m[1]).squaredNorm(),
                                               (corners_m[0] - corners_m[2]).squaredNorm()}));
    return longest > 0.0 ? area_vector(corners_m).norm() / longest : 0.0;
}

Facet::Facet(const FacetSource &source) noexcept
    : normal_(area_vector(source.corners_m).normalized()),
      offset_m_(normal_.dot(source.corners_m[0])), corners_m_(source.corners_m),
      triangle_(source.triangle), material_(source.material), sides_(source.sides) {
    SPRINGDRIVE_ASSERT(normal_.squaredNorm() > 0.5); // 0 where there is no area
    SPRINGDRIVE_ASSERT_AUDIT(min_height_m(source.corners_m) > kRoundOff_m);
}

std::optional<Stop> Facet::stop(const Vector3 &from_m, const Vector3 &to_m, double reach_m,
                                double last_fraction, int &effort_left) const noexcept {
    effort_left -= kFacetEffort;
    double start_m = height_m(from_m);
    double end_m = height_m(to_m);
    double side = 1.0;
    if (start_m < 0.0) {
        if (sides_ == FacetSides::one) {
            return std::nullopt;
        }
        side = -1.0;
        start_m = -start_m;
        end_m = -end_m;
    }
    if (std::min(start_m, end_m) >= reach_m - kSlack_m) {
        return std::nullopt;
    }

    const Vector3 motion = to_m - from_m;
    const double descent_m = start_m - end_m;
    const double enters = start_m > reach_m ? (start_m - reach_m) / descent_m : 0.0;
    if (enters > last_fraction) {
        return std::nullopt;
    }
    const double leaves = end_m < -reach_m ? (start_m + reach_m) / descent_m : 1.0;
    const double minimum = end_m < 0.0 ? start_m / descent_m : 1.0;
    const Vector3 enters_m = from_m + enters * motion;
    const Vector3 leaves_m = from_m + leaves * motion;
    const Vector3 lowest_point_m = from_m + minimum * motion;

    bool is_over_start = true;
    bool pierces = end_m < reach_m - kSlack_m;
    for (std::size_t i = 0; i < 3; ++i) {
        const Vector3 out = outward(i, corners_m_, normal_);
        const double out_enters = out.dot(enters_m - corners_m_[i]);
        const double out_leaves = out.dot(leaves_m - corners_m_[i]);
        const double nearer = std::min(out_enters, out_leaves);
        if (nearer > 0.0 && nearer * nearer > reach_m * reach_m * out.squaredNorm()) {
            return std::nullopt; // passes beyond this edge
        }
        is_over_start = is_over_start && out_enters <= 0.0;
        pierces = pierces && out.dot(lowest_point_m - corners_m_[i]) <= 0.0;
    }
    if (is_over_start) {
        const double kept_m = kept_distance_m(start_m, reach_m);
        if (end_m >= std::min(start_m, nearest_allowed_m(kept_m, reach_m))) {
            return std::nullopt; // it started too near, and comes no nearer
        }
        return plane_above(enters, side, kept_m);
    }
    if (effort_left <= 0) {
        return Stop{enters};
    }
    return stop_at_rim({from_m, to_m, reach_m, last_fraction, enters, enters_m, leaves_m, pierces},
                       effort_left);
}

std::optional<Stop> Facet::stop_at_rim(const Crossing &crossing, int &effort_left) const noexcept {
    const auto nearest_m = [&](const Vector3 &point_m) {
        effort_left -= kNearestEffort;
        return nearest(point_m).point_m;
    };
    const Vector3 start_m = nearest_m(crossing.enters_m);
    if (is_parted(crossing.enters_m, crossing.to_m, start_m, crossing.reach_m)) {
        return std::nullopt;
    }
    if (!crossing.pierces) {
        effort_left -= kGrazingEffort;
        // Computed exactly, since a slide along a neighbour's plane grazes this edge.
        double min_m = crossing.reach_m;
        for (std::size_t i = 0; i < 3; ++i) {
            min_m = std::min(min_m, segment_distance_m(crossing.enters_m, crossing.leaves_m,
                                                       corners_m_[i], corners_m_[(i + 1) % 3]));
        }
        if (min_m >= crossing.reach_m - kSlack_m) {
            return std::nullopt;
        }
    }
    return advance_to_touch(crossing.from_m, crossing.to_m, crossing.enters, start_m,
                            crossing.reach_m, crossing.last_fraction, nearest_m);
}

std::optional<Stop> Facet::touch(const Vector3 &point_m, double reach_m,
                                 double within_m) const noexcept {
    const double height = height_m(point_m);
    if ((height < 0.0 && sides_ == FacetSides::one) || std::abs(height) > reach_m + within_m) {
        return std::nullopt;
    }
    const double side = height < 0.0 ? -1.0 : 1.0;
    if (is_over(point_m)) {
        return plane_above(0.0, side, kept_distance_m(side * height, reach_m));
    }
    const Vector3 nearest_m = nearest(point_m).point_m;
    const Vector3 gap = point_m - nearest_m;
    const double distance_m = gap.norm();
    if (distance_m > reach_m + within_m || distance_m == 0.0) {
        return std::nullopt;
    }
    const Vector3 normal = gap / distance_m;
    return Stop{0.0, normal, normal.dot(nearest_m) + kept_distance_m(distance_m, reach_m)};
}

bool Facet::is_over(const Vector3 &point_m) const noexcept {
    return outward(0, corners_m_, normal_).dot(point_m - corners_m_[0]) <= 0.0 &&
           outward(1, corners_m_, normal_).dot(point_m - corners_m_[1]) <= 0.0 &&
           outward(2, corners_m_, normal_).dot(point_m - corners_m_[2]) <= 0.0;
}

namespace {

using FacetBox = Eigen::AlignedBox3d;

/// A box this much larger than its facet, by area, is worth cutting.
constexpr double kWasteful = 8.0;

/// A cut that saves less than this much of the boxes' surface is not worth a box [m²]: as of boxes
/// of 100 µm, three times what a device resolves.
constexpr double kMinSaving_m2 = 1e-8;

/// How far the corners of a cut facet may be from their exact places, within a metre of the origin
/// [m].
constexpr double kCutRoundOff_m = 1e-15;

/// Half of the surface.
[[nodiscard]] double half_surface_m2(const FacetBox &box) {
    const Vector3 size = box.sizes();
    return size.x() * size.y() + size.y() * size.z() + size.z() * size.x();
}

[[nodiscard]] FacetBox box_of(const FacetSource &facet) {
    FacetBox box(facet.corners_m[0]);
    return box.extend(facet.corners_m[1]).extend(facet.corners_m[2]);
}

/// A convex polygon: a facet cut by the sides of a box.
class CutFacet {
public:
    explicit CutFacet(const FacetSource &facet) {
        std::ranges::copy(facet.corners_m, corners_m_.begin());
    }

    /// Keeps what is on one side of a plane across an axis.
    void keep(Eigen::Index axis, double at_m, bool is_below) {
        std::array<Vector3, kCapacity> kept_m;
        std::size_t kept = 0;
        const double sign = is_below ? 1.0 : -1.0;
        for (std::size_t i = 0; i < size_; ++i) {
            const Vector3 &from_m = corners_m_[i];
            const Vector3 &to_m = corners_m_[(i + 1) % size_];
            const double from_outside_m = sign * (from_m[axis] - at_m);
            const double to_outside_m = sign * (to_m[axis] - at_m);
            if (from_outside_m <= 0.0) {
                kept_m[kept++] = from_m;
            }
            if ((from_outside_m < 0.0 && to_outside_m > 0.0) ||
                (from_outside_m > 0.0 && to_outside_m < 0.0)) {
                const double share = from_outside_m / (from_outside_m - to_outside_m);
                kept_m[kept] = from_m + share * (to_m - from_m);
                kept_m[kept++][axis] = at_m;
            }
        }
        corners_m_ = kept_m;
        size_ = kept;
    }

    [[nodiscard]] FacetBox box() const {
        FacetBox box;
        for (std::size_t i = 0; i < size_; ++i) {
            box.extend(corners_m_[i]);
        }
        return box;
    }

private:
    /// Each of six cuts adds at most one corner.
    static constexpr std::size_t kCapacity = 3 + 6;
    std::array<Vector3, kCapacity> corners_m_;
    std::size_t size_ = 3;
};

/// The part of a facet in a box.
[[nodiscard]] FacetBox box_within(const FacetSource &facet, const FacetBox &limits) {
    CutFacet cut(facet);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        cut.keep(axis, limits.min()[axis], false);
        cut.keep(axis, limits.max()[axis], true);
    }
    FacetBox box = cut.box();
    if (box.isEmpty()) {
        return box;
    }
    const Vector3 margin = Vector3::Constant(
        kCutRoundOff_m *
        (1.0 + limits.min().cwiseAbs().cwiseMax(limits.max().cwiseAbs()).maxCoeff()));
    return {box.min() - margin, box.max() + margin};
}

/// The best cut of a box in two.
struct BoxCut {
    double saves_m2 = 0.0;
    std::uint32_t box = 0;
    std::array<FacetBox, 2> halves_m;

    [[nodiscard]] bool operator<(const BoxCut &other) const {
        return saves_m2 != other.saves_m2 ? saves_m2 < other.saves_m2 : box > other.box;
    }
};

[[nodiscard]] BoxCut best_cut(const FacetSource &facet, const FacetBox &box_m, std::uint32_t box) {
    BoxCut best;
    best.box = box;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const double at_m = 0.5 * (box_m.min()[axis] + box_m.max()[axis]);
        std::array<FacetBox, 2> halves_m{box_m, box_m};
        halves_m[0].max()[axis] = at_m;
        halves_m[1].min()[axis] = at_m;
        double saves_m2 = half_surface_m2(box_m);
        for (FacetBox &half_m : halves_m) {
            half_m = box_within(facet, half_m);
            if (half_m.isEmpty()) {
                saves_m2 = 0.0; // by round-off
                break;
            }
            saves_m2 -= half_surface_m2(half_m);
        }
        if (saves_m2 > best.saves_m2) {
            best.saves_m2 = saves_m2;
            best.halves_m = halves_m;
        }
    }
    return best;
}

[[nodiscard]] bool is_wasteful(const FacetSource &facet, const FacetBox &box_m) {
    const double area2_m2 = (facet.corners_m[1] - facet.corners_m[0])
                                .cross(facet.corners_m[2] - facet.corners_m[0])
                                .norm();
    return half_surface_m2(box_m) > kWasteful * area2_m2;
}

} // namespace

FacetBoxes boxes_of(const std::vector<FacetSource> &facets) {
    FacetBoxes found;
    found.boxes_m.reserve(facets.size());
    found.facet_of_box.reserve(facets.size());
    std::priority_queue<BoxCut> cuts;
    const auto offer = [&](std::uint32_t box) {
        BoxCut cut = best_cut(facets[found.facet_of_box[box]], found.boxes_m[box], box);
        if (cut.saves_m2 >= kMinSaving_m2) {
            cuts.push(std::move(cut));
        }
    };
    for (std::uint32_t i = 0; i < facets.size(); ++i) {
        stop_if_given_up(i);
        found.boxes_m.push_back(box_of(facets[i]));
        found.facet_of_box.push_back(i);
        if (facets[i].is_crowded || is_wasteful(facets[i], found.boxes_m.back())) {
            offer(i);
        }
    }
    while (!cuts.empty() && found.boxes_m.size() < facets.size() + kMaxMoreBoxes) {
        const BoxCut cut = cuts.top();
        cuts.pop();
        const auto second = static_cast<std::uint32_t>(found.boxes_m.size());
        stop_if_given_up(second);
        found.boxes_m[cut.box] = cut.halves_m[0];
        found.boxes_m.push_back(cut.halves_m[1]);
        found.facet_of_box.push_back(found.facet_of_box[cut.box]);
        offer(cut.box);
        offer(second);
    }
    return found;
}

} // namespace springdrive::contact
