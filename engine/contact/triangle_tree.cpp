#include "engine/contact/triangle_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace springdrive {

namespace {

constexpr double kMiss = std::numeric_limits<double>::max();

/// A motion, with what a test against many boxes needs.
struct Motion {
    Vector3 from_m;
    Vector3 to_m;
    Vector3 fractions_per_metre;

    Motion(const Vector3 &from, const Vector3 &to) noexcept : from_m(from), to_m(to) {
        // Far less than round-off, but its inverse is finite: no zero times infinity later.
        constexpr double kLeast_m = 1e-100;
        for (int axis = 0; axis < 3; ++axis) {
            const double length = to[axis] - from[axis];
            fractions_per_metre[axis] = 1.0 / (std::abs(length) < kLeast_m ? kLeast_m : length);
        }
    }
};

/// Where the motion enters the box, as a fraction of its length, or kMiss if it does not before
/// `last_fraction`.
[[nodiscard]] double entry(const Motion &motion, const TreeBounds &box,
                           double last_fraction) noexcept {
    double enters = 0.0;
    double leaves = last_fraction;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<Eigen::Index>(axis);
        const double scale = motion.fractions_per_metre[i];
        const double at_lower = (static_cast<double>(box.lower[axis]) - motion.from_m[i]) * scale;
        const double at_upper = (static_cast<double>(box.upper[axis]) - motion.from_m[i]) * scale;
        enters = std::max(enters, std::min(at_lower, at_upper));
        leaves = std::min(leaves, std::max(at_lower, at_upper));
    }
    return enters <= leaves ? enters : kMiss;
}

/// Branches still to be searched: at most one on each level above the current one.
class BranchStack {
public:
    void push(const TreeBranch &branch, double entry) noexcept {
        waiting_[static_cast<std::size_t>(size_++)] = {branch, entry};
    }

    /// Takes branches off until one is entered before `last_fraction`. False if there is none.
    [[nodiscard]] bool pop(TreeBranch &branch, double last_fraction) noexcept {
        while (size_ > 0) {
            const Waiting &top = waiting_[static_cast<std::size_t>(--size_)];
            if (top.entry <= last_fraction) {
                branch = top.branch;
                return true;
            }
        }
        return false;
    }

private:
    struct Waiting {
        TreeBranch branch;
        double entry = 0.0;
    };
    std::array<Waiting, kDeepestBranch> waiting_;
    int size_ = 0;
};

} // namespace

TriangleTree::TriangleTree(const std::vector<FacetSource> &sources) {
    TreeLayout layout = lay_out_tree(sources);
    root_ = layout.root;
    nodes_ = std::move(layout.nodes);
    facets_.reserve(sources.size());
    for (const std::uint32_t source : layout.order) {
        facets_.emplace_back(sources[source]);
    }
}

std::optional<SurfaceHit> TriangleTree::first_hit(const Vector3 &from_m,
                                                  const Vector3 &to_m) const noexcept {
    const Motion motion(from_m, to_m);
    SurfaceHit hit{1.0, nullptr};
    BranchStack waiting;
    TreeBranch branch = root_;
    do {
        while (branch.facet_count == 0 && !nodes_.empty()) {
            const TreeNode &node = nodes_[branch.first];
            const double entry_0 = entry(motion, node.bounds[0], hit.fraction);
            const double entry_1 = entry(motion, node.bounds[1], hit.fraction);
            const std::size_t near = entry_1 < entry_0 ? 1 : 0;
            if (std::min(entry_0, entry_1) == kMiss) {
                break;
            }
            if (std::max(entry_0, entry_1) != kMiss) {
                waiting.push(node.branches[1 - near], std::max(entry_0, entry_1));
            }
            branch = node.branches[near];
        }
        for (std::uint32_t i = 0; i < branch.facet_count; ++i) {
            const Facet &facet = facets_[branch.first + i];
            const std::optional<double> fraction = facet.stop(from_m, to_m);
            if (fraction && (hit.facet == nullptr || *fraction < hit.fraction)) {
                hit = {*fraction, &facet};
            }
        }
    } while (waiting.pop(branch, hit.fraction));
    return hit.facet == nullptr ? std::nullopt : std::optional(hit);
}

} // namespace springdrive
