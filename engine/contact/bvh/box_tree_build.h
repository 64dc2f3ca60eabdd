// Builds the nodes of a BoxTree.
#pragma once

#include "engine/contact/bvh/box_node.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <span>
#include <vector>

namespace springdrive::contact {

struct BoxTreeLayout {
    std::vector<BoxNode> nodes;       ///< the root first; none if there are no boxes
    std::vector<std::uint32_t> order; ///< item i is boxes[order[i]]
};

/// In `threads` threads; the same for any number of them.
/// @pre boxes are finite and not empty [m]; fewer than 2^30
[[nodiscard]] BoxTreeLayout lay_out_boxes(std::span<const Eigen::AlignedBox3d> boxes,
                                          unsigned threads);

} // namespace springdrive::contact
