#include "engine/contact/facet.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace springdrive {

namespace {

/// A motion may use up this much of the clearance [m]: planes hold a proxy up to round-off. Where
/// little is left there is no such slack, or a slow one would use it all up.
constexpr double kSlack_m = 1e-12;

/// Of the three corners the pair of edges that meet at the widest angle gives the normal with the
/// least cancellation: those that do not include the longest edge.
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

[[nodiscard]] double squared_distance_to_segment(const Vector3 &point_m, const Vector3 &a_m,
                                                 const Vector3 &b_m) noexcept {
    const Vector3 along = b_m - a_m;
    const double fraction = std::clamp((point_m - a_m).dot(along) / along.squaredNorm(), 0.0, 1.0);
    return (point_m - a_m - fraction * along).squaredNorm();
}

} // namespace

double smallest_height_m(const std::array<Vector3, 3> &corners_m) noexcept {
    const double longest = std::sqrt(std::max({(corners_m[1] - corners_m[0]).squaredNorm(),
                                               (corners_m[2] - corners_m[1]).squaredNorm(),
                                               (corners_m[0] - corners_m[2]).squaredNorm()}));
    return longest > 0.0 ? area_vector(corners_m).norm() / longest : 0.0;
}

Facet::Facet(const FacetSource &source) noexcept
    : normal_(area_vector(source.corners_m).normalized()),
      offset_m_(normal_.dot(source.corners_m[0])), sides_(source.sides), triangle_(source.triangle),
      corners_m_(source.corners_m) {}

std::optional<double> Facet::stop(const Vector3 &from_m, const Vector3 &to_m) const noexcept {
    double start_m = height_m(from_m);
    double end_m = height_m(to_m);
    if (sides_ == FacetSides::two && start_m < 0.0) {
        start_m = -start_m;
        end_m = -end_m;
    }
    const bool starts_in_front =
        sides_ == FacetSides::two ? start_m > 0.0 : start_m >= -kRoundOff_m;
    const double slack_m = end_m < kRoundOff_m ? 0.0 : kSlack_m;
    if (!starts_in_front || !(end_m < std::min(start_m, kClearance_m) - slack_m)) {
        return std::nullopt;
    }
    // Whether the facet is in the way is asked where the motion is lowest in front of it: where it
    // pierces the plane, or at its end.
    const double descent_m = start_m - end_m;
    const double lowest = std::clamp(start_m / descent_m, 0.0, 1.0);
    if (!covers(from_m + lowest * (to_m - from_m))) {
        return std::nullopt;
    }
    return std::max(0.0, (start_m - kClearance_m) / descent_m);
}

bool Facet::covers(const Vector3 &point_in_plane_m) const noexcept {
    bool is_on_rim = false;
    for (std::size_t i = 0; i < 3; ++i) {
        const Vector3 edge = corners_m_[(i + 1) % 3] - corners_m_[i];
        const double outside = edge.cross(normal_).dot(point_in_plane_m - corners_m_[i]);
        if (outside > 0.0) {
            if (outside * outside > kRim_m * kRim_m * edge.squaredNorm()) {
                return false;
            }
            is_on_rim = true;
        }
    }
    if (!is_on_rim) {
        return true;
    }
    // Straight rims would meet in a spike far beyond a sharp corner, so measure.
    for (std::size_t i = 0; i < 3; ++i) {
        if (squared_distance_to_segment(point_in_plane_m, corners_m_[i], corners_m_[(i + 1) % 3]) <=
            kRim_m * kRim_m) {
            return true;
        }
    }
    return false;
}

} // namespace springdrive
