// Arranges facets in a binary tree of boxes so that a search looks into few of them: a binned
// build by the surface-area heuristic (a box is searched about as often as its surface is large).
#pragma once

#include "engine/contact/facet.h"

#include <array>
#include <cstdint>
#include <vector>

namespace springdrive {

/// Corners of a box, rounded outwards from double [m].
struct TreeBounds {
    std::array<float, 3> lower{};
    std::array<float, 3> upper{};
};

/// A run of facets, or the index of a node if `facet_count` is zero.
struct TreeBranch {
    std::uint32_t first = 0;
    std::uint32_t facet_count = 0;
};

/// Both branches of a fork with their boxes, in one cache line.
struct alignas(64) TreeNode {
    std::array<TreeBounds, 2> bounds;
    std::array<TreeBranch, 2> branches;
};

struct TreeLayout {
    TreeBranch root;
    std::vector<TreeNode> nodes;
    std::vector<std::uint32_t> order; ///< of the facets: leaves are runs in this order
};

/// No branch lies deeper below the root: a search needs no larger stack.
inline constexpr int kDeepestBranch = 80;

[[nodiscard]] TreeLayout lay_out_tree(const std::vector<FacetSource> &facets);

} // namespace springdrive
