// Builds the nodes of a BoxTree: from the root on, runs of boxes are divided into up to eight, by
// the surface-area heuristic (a box is visited about in proportion to its surface area) with binned
// centres.
#pragma once

#include "engine/contact/bvh/box_tree.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <limits>
#include <span>

namespace springdrive::contact {

/// A box, or none yet. Lanes x, y, z; the fourth is unused.
struct Bounds {
    Float4 lower = all_lanes(std::numeric_limits<float>::infinity());
    Float4 upper = all_lanes(-std::numeric_limits<float>::infinity());

    void extend(const Bounds &other) noexcept {
        lower = smaller(lower, other.lower);
        upper = larger(upper, other.upper);
    }
};

/// A box as the build sorts it: in floats, in two registers, with its number in the fourth lane of
/// its lower corner.
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

/// In `threads` threads; the same for any number of them.
/// @pre boxes are finite and not empty [m]; fewer than 2^30
[[nodiscard]] BoxTreeLayout lay_out_boxes(std::span<const Eigen::AlignedBox3d> boxes,
                                          unsigned threads);

} // namespace springdrive::contact
