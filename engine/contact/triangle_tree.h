// Finds the first facet that stops a straight motion, in a tree of boxes.
#pragma once

#include "base/vector.h"
#include "engine/contact/facet.h"
#include "engine/contact/tree_layout.h"

#include <optional>
#include <vector>

namespace springdrive {

/// Where a motion from a to b has to end: at a + fraction (b − a), a clearance above the facet.
struct SurfaceHit {
    double fraction = 0.0;
    const Facet *facet = nullptr; ///< lives as long as the tree
};

/// A binary tree of axis-aligned boxes, built once by the surface-area heuristic and then only
/// read, from any thread. Each box holds its facets, their rims and all that is too near to them.
class TriangleTree {
public:
    TriangleTree() = default;
    explicit TriangleTree(const std::vector<FacetSource> &sources);

    /// What stops the motion from `from_m` to `to_m` first, if anything does. RT-safe.
    [[nodiscard]] std::optional<SurfaceHit> first_hit(const Vector3 &from_m,
                                                      const Vector3 &to_m) const noexcept;

    /// In the order of the tree.
    [[nodiscard]] const std::vector<Facet> &facets() const noexcept { return facets_; }

private:
    TreeBranch root_;
    std::vector<TreeNode> nodes_;
    std::vector<Facet> facets_;
};

} // namespace springdrive
