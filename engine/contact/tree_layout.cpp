#include "engine/contact/tree_layout.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>

namespace springdrive {

namespace {

using Box = Eigen::AlignedBox3d;

constexpr std::size_t kLargestLeaf = 4;
constexpr int kBins = 16;

/// Cost of looking at a node, where testing a facet costs 1.
constexpr double kNodeCost = 1.0;

/// From this depth on branches are halved, which ends within the 32 levels that remain.
constexpr int kHalvingDepth = kDeepestBranch - 32;

/// Boxes reach this far beyond their triangles [m]: all that a facet stops lies within.
constexpr double kMargin_m = kClearance_m + kRim_m;

[[nodiscard]] double half_area(const Box &box) {
    const Vector3 size = box.sizes();
    return box.isEmpty() ? 0.0 : size.x() * size.y() + size.y() * size.z() + size.z() * size.x();
}

[[nodiscard]] TreeBounds rounded_outwards(const Box &box) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    TreeBounds bounds;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<Eigen::Index>(axis);
        bounds.lower[axis] = std::nextafter(static_cast<float>(box.min()[i]), -kInfinity);
        bounds.upper[axis] = std::nextafter(static_cast<float>(box.max()[i]), kInfinity);
    }
    return bounds;
}

struct Item {
    Box box;
    Vector3 centre;
    std::uint32_t facet = 0;
};

struct Bin {
    Box box;
    std::size_t count = 0;

    void add(const Bin &other) {
        box.extend(other.box);
        count += other.count;
    }
};

/// A plane across one axis, on the wall of a bin.
struct Split {
    int axis = -1;
    int bin = 0; ///< first bin of the second half
    double cost = std::numeric_limits<double>::infinity();
};

/// Sorts centres into equal bins along one axis of the box that holds them all.
class Binning {
public:
    Binning(const Box &centres, int axis)
        : axis_(axis), lower_(centres.min()[axis]),
          bins_per_metre_(kBins / (centres.max()[axis] - centres.min()[axis])) {}

    [[nodiscard]] int bin_of(const Item &item) const {
        return std::min(kBins - 1,
                        static_cast<int>((item.centre[axis_] - lower_) * bins_per_metre_));
    }

private:
    int axis_;
    double lower_;
    double bins_per_metre_;
};

/// The cheapest split along one axis; its cost is relative to the half-area of the whole.
[[nodiscard]] Split best_split(std::span<const Item> items, const Box &centres, int axis) {
    const Binning binning(centres, axis);
    std::array<Bin, kBins> bins;
    for (const Item &item : items) {
        bins[static_cast<std::size_t>(binning.bin_of(item))].add({item.box, 1});
    }
    std::array<double, kBins> cost_above{}; // of bins [i, kBins)
    Bin above;
    for (std::size_t i = kBins - 1; i > 0; --i) {
        above.add(bins[i]);
        cost_above[i] = half_area(above.box) * static_cast<double>(above.count);
    }
    Split best;
    Bin below;
    for (std::size_t i = 1; i < kBins; ++i) {
        below.add(bins[i - 1]);
        const double cost = half_area(below.box) * static_cast<double>(below.count) + cost_above[i];
        if (below.count > 0 && below.count < items.size() && cost < best.cost) {
            best = {axis, static_cast<int>(i), cost};
        }
    }
    return best;
}

[[nodiscard]] Split best_split(std::span<const Item> items, const Box &centres) {
    Split best;
    for (int axis = 0; axis < 3; ++axis) {
        if (centres.sizes()[axis] > 0.0) {
            const Split split = best_split(items, centres, axis);
            best = split.cost < best.cost ? split : best;
        }
    }
    return best;
}

class Builder {
public:
    explicit Builder(std::vector<Item> items) : items_(std::move(items)) {
        layout_.nodes.reserve(items_.size());
        if (!items_.empty()) {
            layout_.root = build(items_, 0);
        }
        layout_.order.resize(items_.size());
        std::ranges::transform(items_, layout_.order.begin(), &Item::facet);
    }

    [[nodiscard]] TreeLayout take() { return std::move(layout_); }

private:
    TreeBranch build(std::span<Item> items, int depth) {
        Box box;
        Box centres;
        for (const Item &item : items) {
            box.extend(item.box);
            centres.extend(item.centre);
        }
        const Split split = best_split(items, centres);
        const double leaf_cost = half_area(box) * static_cast<double>(items.size());
        const double fork_cost = half_area(box) * kNodeCost + split.cost;
        if (items.size() <= kLargestLeaf && leaf_cost <= fork_cost) {
            return {static_cast<std::uint32_t>(items.data() - items_.data()),
                    static_cast<std::uint32_t>(items.size())};
        }
        const std::size_t lower_half = divide(items, centres, split, depth);
        return fork({items.first(lower_half), items.subspan(lower_half)}, depth);
    }

    /// Reorders `items` into two halves, neither empty. Returns the size of the first.
    [[nodiscard]] static std::size_t divide(std::span<Item> items, const Box &centres,
                                            const Split &split, int depth) {
        if (split.axis >= 0 && depth < kHalvingDepth) {
            const Binning binning(centres, split.axis);
            const auto upper = std::partition(items.begin(), items.end(), [&](const Item &item) {
                return binning.bin_of(item) < split.bin;
            });
            return static_cast<std::size_t>(upper - items.begin());
        }
        Eigen::Index axis = 0;
        centres.sizes().maxCoeff(&axis);
        const std::size_t half = items.size() / 2;
        std::ranges::nth_element(items, items.begin() + static_cast<std::ptrdiff_t>(half), {},
                                 [axis](const Item &item) { return item.centre[axis]; });
        return half;
    }

    TreeBranch fork(const std::array<std::span<Item>, 2> &halves, int depth) {
        const std::size_t index = layout_.nodes.size();
        layout_.nodes.emplace_back();
        for (std::size_t i = 0; i < 2; ++i) {
            Box box;
            for (const Item &item : halves[i]) {
                box.extend(item.box);
            }
            const TreeBranch branch = build(halves[i], depth + 1);
            layout_.nodes[index].bounds[i] = rounded_outwards(box);
            layout_.nodes[index].branches[i] = branch;
        }
        return {static_cast<std::uint32_t>(index), 0};
    }

    std::vector<Item> items_;
    TreeLayout layout_;
};

} // namespace

TreeLayout lay_out_tree(const std::vector<FacetSource> &facets) {
    const Vector3 margin = Vector3::Constant(kMargin_m);
    std::vector<Item> items(facets.size());
    for (std::uint32_t i = 0; i < items.size(); ++i) {
        for (const Vector3 &corner : facets[i].corners_m) {
            items[i].box.extend(corner - margin);
            items[i].box.extend(corner + margin);
        }
        items[i].centre = items[i].box.center();
        items[i].facet = i;
    }
    return Builder(std::move(items)).take();
}

} // namespace springdrive
