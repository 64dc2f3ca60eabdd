// One touchable triangle, prepared for the question that the proxy asks all the time: how far may a
// straight motion go before it comes too near?
//
// Every facet is a little larger than its triangle: by kRim_m, in its plane, with round corners.
// The rims of neighbours overlap, so that no motion slips through the round-off between them,
// through a crack narrower than the rim, or where a vertex meets the middle of another's edge.
#pragma once

#include "base/vector.h"

#include <array>
#include <cstdint>
#include <optional>

namespace springdrive {

/// Kept between proxy and surface [m]: 0.1 µm, far below what an encoder resolves or a hand
/// feels, far above round-off.
inline constexpr double kClearance_m = 1e-7;

/// Width of the overlap [m]. Less than the clearance, so that a proxy that comes over an edge from
/// one face passes beside the rim of the other.
inline constexpr double kRim_m = 2.5e-8;

/// Heights below this count as round-off [m]: far above the 1e-16 that arithmetic on metres leaves.
inline constexpr double kRoundOff_m = 1e-9;

enum class FacetSides : std::uint8_t {
    one, ///< bounds a volume: stops what comes from the side its normal points to
    two, ///< a sheet: stops what comes from either side
};

/// What a facet is made from.
struct FacetSource {
    std::array<Vector3, 3> corners_m;
    FacetSides sides = FacetSides::one;
    std::uint32_t triangle = 0; ///< its index in the soup
};

/// Smallest of a triangle's three heights [m]; zero if it has no area.
[[nodiscard]] double smallest_height_m(const std::array<Vector3, 3> &corners_m) noexcept;

class Facet {
public:
    /// @pre smallest_height_m(source.corners_m) is above round-off
    explicit Facet(const FacetSource &source) noexcept;

    /// How much of the motion from `from_m` to `to_m` leaves the clearance over the facet, if not
    /// all of it does: none where it starts too near already and comes nearer.
    ///
    /// Motions that start behind a one-sided facet are let through, but for those within round-off
    /// of it: they have only sunk in.
    [[nodiscard]] std::optional<double> stop(const Vector3 &from_m,
                                             const Vector3 &to_m) const noexcept;

    /// Unit; counter-clockwise winding turns about it.
    [[nodiscard]] const Vector3 &normal() const noexcept { return normal_; }

    /// Above the plane of the facet, on the side of the normal [m].
    [[nodiscard]] double height_m(const Vector3 &point_m) const noexcept {
        return normal_.dot(point_m) - offset_m_;
    }

    [[nodiscard]] FacetSides sides() const noexcept { return sides_; }
    [[nodiscard]] std::uint32_t triangle() const noexcept { return triangle_; }

private:
    [[nodiscard]] bool covers(const Vector3 &point_in_plane_m) const noexcept;

    Vector3 normal_;
    double offset_m_;
    FacetSides sides_;
    std::uint32_t triangle_;
    std::array<Vector3, 3> corners_m_; ///< read last: most motions pass the plane
};

} // namespace springdrive
