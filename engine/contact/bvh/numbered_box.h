// A box as the build of a BoxTree moves it about: in floats, with its number, in two registers.
#pragma once

#include "engine/contact/bvh/float4.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <limits>

namespace springdrive::contact {

/// A box, or none yet. Lanes x, y, z; what the fourth holds means nothing.
struct Bounds {
    Float4 lower = all_lanes(std::numeric_limits<float>::infinity());
    Float4 upper = all_lanes(-std::numeric_limits<float>::infinity());

    void extend(const Bounds &other) noexcept {
        lower = smaller(lower, other.lower);
        upper = larger(upper, other.upper);
    }
};

/// A box and, in the fourth lane of its lower corner, its number.
class NumberedBox {
public:
    NumberedBox() = default;

    /// Rounded outwards from double.
    /// @pre `number` is below 2^30
    NumberedBox(const Eigen::AlignedBox3d &box, std::uint32_t number) noexcept;

    [[nodiscard]] const Bounds &bounds() const noexcept { return bounds_; }
    [[nodiscard]] Float4 twice_centre() const noexcept { return bounds_.lower + bounds_.upper; }
    [[nodiscard]] std::uint32_t number() const noexcept;

private:
    Bounds bounds_;
};

} // namespace springdrive::contact
