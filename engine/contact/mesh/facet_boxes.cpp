#include "engine/contact/mesh/facet_boxes.h"

#include "base/cancellation.h"

#include <algorithm>
#include <array>
#include <queue>
#include <utility>

namespace springdrive::contact {

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
