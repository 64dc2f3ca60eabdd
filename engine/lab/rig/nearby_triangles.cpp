#include "engine/lab/rig/nearby_triangles.h"

#include <algorithm>
#include <numeric>

namespace springdrive::rig {

namespace {

constexpr std::uint32_t kMaxInLeaf = 4;

} // namespace

NearbyTriangles::NearbyTriangles(std::span<const PlainTriangle> triangles)
    : triangles_(triangles), order_(triangles.size()) {
    std::iota(order_.begin(), order_.end(), 0U);
    std::vector<Vector3> middles_m;
    middles_m.reserve(triangles.size());
    for (const PlainTriangle &triangle : triangles) {
        middles_m.emplace_back(triangle.bounds().center());
    }
    if (!triangles.empty()) {
        nodes_.reserve(triangles.size());
        add(0, static_cast<std::uint32_t>(triangles.size()), middles_m);
    }
}

std::uint32_t NearbyTriangles::add(std::uint32_t first, std::uint32_t last,
                                   const std::vector<Vector3> &middles_m) {
    const auto index = static_cast<std::uint32_t>(nodes_.size());
    Node node;
    node.first = first;
    node.last = last;
    Eigen::AlignedBox3d middles_box;
    for (std::uint32_t i = first; i < last; ++i) {
        node.box.extend(triangles_[order_[i]].bounds());
        middles_box.extend(middles_m[order_[i]]);
    }
    nodes_.push_back(node);
    if (last - first > kMaxInLeaf) {
        Eigen::Index axis = 0;
        middles_box.diagonal().maxCoeff(&axis);
        const std::uint32_t half = first + (last - first) / 2;
        std::nth_element(order_.begin() + first, order_.begin() + half, order_.begin() + last,
                         [&](std::uint32_t a, std::uint32_t b) {
                             return middles_m[a][axis] < middles_m[b][axis];
                         });
        add(first, half, middles_m);
        const std::uint32_t other = add(half, last, middles_m);
        nodes_[index].other = other;
    }
    return index;
}

std::vector<std::size_t> NearbyTriangles::within(const Vector3 &centre_m, double radius_m) const {
    std::vector<std::size_t> found;
    std::vector<std::uint32_t> waiting;
    if (!nodes_.empty()) {
        waiting.push_back(0);
    }
    const double radius_m2 = radius_m * radius_m;
    while (!waiting.empty()) {
        const std::uint32_t index = waiting.back();
        waiting.pop_back();
        const Node &node = nodes_[index];
        if (node.box.squaredExteriorDistance(centre_m) > radius_m2) {
            continue;
        }
        if (node.other != 0) {
            waiting.push_back(node.other);
            waiting.push_back(index + 1);
            continue;
        }
        for (std::uint32_t i = node.first; i < node.last; ++i) {
            if (triangles_[order_[i]].bounds().squaredExteriorDistance(centre_m) <= radius_m2) {
                found.push_back(order_[i]);
            }
        }
    }
    std::ranges::sort(found);
    return found;
}

} // namespace springdrive::rig
