#include "engine/contact/bvh/box_tree.h"

namespace springdrive::contact {

BoxTree::BoxTree(std::span<const Eigen::AlignedBox3d> boxes, unsigned threads)
    : layout_(lay_out_boxes(boxes, threads)) {}

std::size_t BoxTree::bytes() const noexcept {
    return sizeof *this + layout_.nodes.capacity() * sizeof(BoxNode) +
           layout_.order.capacity() * sizeof(std::uint32_t);
}

} // namespace springdrive::contact
