#include "engine/contact/bvh/box_tree_build.h"

#include "base/assertions.h"
#include "base/cancellation.h"
#include "base/parallel.h"
#include "base/vector.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>
#include <utility>

namespace springdrive::contact {

namespace {

/// Numbers are kept as the bits of floats that are never used in arithmetic: from here on, 2^30 bit
/// patterns are those of normal floats, which no processor handles slowly.
constexpr std::uint32_t kNumberOffset = 0x3F800000U;

/// The nearest float, or if that lies above, one of the next two below.
[[nodiscard]] float rounded_down(double value) noexcept {
    const auto nearest = static_cast<float>(value);
    const float step = std::abs(nearest) * 0x1p-23F + std::numeric_limits<float>::min();
    return double{nearest} > value ? nearest - step : nearest;
}

[[nodiscard]] float rounded_up(double value) noexcept { return -rounded_down(-value); }

/// Consecutive boxes of the list of all boxes, and their bounds.
struct BoxRun {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    Bounds bounds;        ///< of the boxes [m]
    Bounds twice_centres; ///< of their centres [2 m]
};

/// At most as many runs as a node has lanes, consecutive.
struct BoxFork {
    std::array<BoxRun, kBoxLanes> runs;
    std::size_t size = 0;
};

enum class SplitRule : std::uint8_t {
    surface_area,
    halves, ///< by number: no run stays larger than half, rounded up
};

class BoxSplitter {
public:
    /// @param boxes  reordered by `fork`
    /// @param gap_m  added to a box's edges for the comparison of areas, so that points, lines and
    ///               planes compare too
    BoxSplitter(std::span<NumberedBox> boxes, float gap_m) noexcept
        : boxes_(boxes), gap_m_(gap_m) {}

    [[nodiscard]] BoxRun run(std::uint32_t first, std::uint32_t count) const noexcept;

    /// Divides a run into two runs or more, or into its items if they fit into one node. May be
    /// called for several runs at a time if they do not overlap.
    [[nodiscard]] BoxFork fork(const BoxRun &whole, SplitRule rule) const;

private:
    /// A wall between two bins.
    struct Wall {
        int axis = -1;
        int bin = 0; ///< the first above the wall
        float cost = std::numeric_limits<float>::infinity();
    };

    [[nodiscard]] float half_area(const Bounds &bounds) const noexcept;
    [[nodiscard]] Wall cheapest_wall(const BoxRun &whole) const noexcept;
    [[nodiscard]] std::uint32_t reorder(const BoxRun &whole, const Wall &wall) const noexcept;
    [[nodiscard]] std::uint32_t reorder_in_halves(const BoxRun &whole) const;
    void split(BoxFork &fork, std::size_t index, SplitRule rule) const;
    void open(BoxFork &fork, std::size_t index) const noexcept;

    std::span<NumberedBox> boxes_;
    float gap_m_;
};

constexpr int kMaxBoxBins = 16;

struct BoxBin {
    Bounds bounds;
    std::uint32_t count = 0;

    void add(const BoxBin &other) noexcept {
        bounds.extend(other.bounds);
        count += other.count;
    }
};

/// Which bin a centre falls into.
class BoxBinning {
public:
    /// @param count  of boxes: few do not need many bins
    BoxBinning(const Bounds &twice_centres, std::uint32_t count) noexcept
        : bins_(count < 32 ? kMaxBoxBins / 2 : kMaxBoxBins), lower_(twice_centres.lower) {
        const Float4 size = twice_centres.upper - twice_centres.lower;
        for (int axis = 0; axis < 3; ++axis) {
            // All in the first bin where their centres coincide.
            bins_per_unit_[axis] =
                size[axis] > 1e-30F ? static_cast<float>(bins_) / size[axis] : 0.0F;
        }
    }

    [[nodiscard]] int bins() const noexcept { return bins_; }

    /// For x, y and z. Clamped to the range of bins, so round-off does no harm.
    [[nodiscard]] Mask4 bins_of(Float4 twice_centre) const noexcept {
        const Float4 place = (twice_centre - lower_) * bins_per_unit_;
        const Float4 last = all_lanes(static_cast<float>(bins_ - 1));
        return __builtin_convertvector(larger(smaller(place, last), Float4{}), Mask4);
    }

private:
    int bins_;
    Float4 lower_;
    Float4 bins_per_unit_{};
};

/// Boxes counted by where their centres lie, in equal bins along all three axes at once.
class BoxBins {
public:
    explicit BoxBins(int bins) noexcept {
        for (auto &axis : bins_) {
            std::fill_n(axis.begin(), bins, BoxBin{});
        }
    }

    void add(const Bounds &bounds, Mask4 bins) noexcept {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            bins_[axis][static_cast<std::size_t>(bins[axis])].add({bounds, 1});
        }
    }

    [[nodiscard]] const BoxBin &at(int axis, int bin) const noexcept {
        return bins_[static_cast<std::size_t>(axis)][static_cast<std::size_t>(bin)];
    }

private:
    std::array<std::array<BoxBin, kMaxBoxBins>, 3> bins_;
};

[[nodiscard]] std::size_t largest_lane(Float4 values) noexcept {
    const std::size_t of_first_two = values[1] > values[0] ? 1 : 0;
    return values[2] > values[of_first_two] ? 2 : of_first_two;
}

BoxRun BoxSplitter::run(std::uint32_t first, std::uint32_t count) const noexcept {
    BoxRun run{first, count, {}, {}};
    for (const NumberedBox &box : boxes_.subspan(first, count)) {
        run.bounds.extend(box.bounds());
        run.twice_centres.extend({box.twice_centre(), box.twice_centre()});
    }
    return run;
}

BoxFork BoxSplitter::fork(const BoxRun &whole, SplitRule rule) const {
    BoxFork fork;
    fork.runs[0] = whole;
    fork.size = 1;
    // The run to be split next is the one that is visited most often, of those that would not fit
    // into one node.
    const auto choose = [&](std::uint32_t min_count, std::uint32_t max_count) {
        std::optional<std::size_t> chosen;
        float largest = -1.0F;
        for (std::size_t i = 0; i < fork.size; ++i) {
            const BoxRun &run = fork.runs[i];
            const float weight =
                rule == SplitRule::halves ? static_cast<float>(run.count) : half_area(run.bounds);
            if (run.count >= min_count && run.count <= max_count && weight > largest) {
                largest = weight;
                chosen = i;
            }
        }
        return chosen;
    };
    while (fork.size < kBoxLanes) {
        const auto too_large = choose(kBoxLanes + 1, whole.count);
        if (!too_large) {
            break;
        }
        stop_if_given_up();
        split(fork, *too_large, rule);
    }
    while (fork.size < kBoxLanes) {
        const auto lanes_left = static_cast<std::uint32_t>(kBoxLanes - fork.size);
        const auto fitting = choose(2, lanes_left + 1);
        if (!fitting) {
            break;
        }
        open(fork, *fitting);
    }
    return fork;
}

float BoxSplitter::half_area(const Bounds &bounds) const noexcept {
    const Float4 size = bounds.upper - bounds.lower + all_lanes(gap_m_);
    const Float4 area = size * __builtin_shufflevector(size, size, 1, 2, 0, 3);
    return area[0] + area[1] + area[2];
}

BoxSplitter::Wall BoxSplitter::cheapest_wall(const BoxRun &whole) const noexcept {
    const BoxBinning binning(whole.twice_centres, whole.count);
    BoxBins bins(binning.bins());
    for (const NumberedBox &box : boxes_.subspan(whole.first, whole.count)) {
        bins.add(box.bounds(), binning.bins_of(box.twice_centre()));
    }
    // A node costs the same whether it is full or not.
    const auto cost = [this](const BoxBin &side) {
        const std::size_t nodes = (side.count + kBoxLanes - 1) / kBoxLanes;
        return half_area(side.bounds) * static_cast<float>(nodes);
    };
    Wall best;
    for (int axis = 0; axis < 3; ++axis) {
        std::array<float, kMaxBoxBins> cost_above{};
        BoxBin above;
        for (int i = binning.bins() - 1; i > 0; --i) {
            above.add(bins.at(axis, i));
            cost_above[static_cast<std::size_t>(i)] = cost(above);
        }
        BoxBin below;
        for (int i = 1; i < binning.bins(); ++i) {
            below.add(bins.at(axis, i - 1));
            const float sum = cost(below) + cost_above[static_cast<std::size_t>(i)];
            if (sum < best.cost && below.count > 0 && below.count < whole.count) {
                best = {axis, i, sum};
            }
        }
    }
    return best;
}

std::uint32_t BoxSplitter::reorder(const BoxRun &whole, const Wall &wall) const noexcept {
    const BoxBinning binning(whole.twice_centres, whole.count);
    const std::span<NumberedBox> boxes = boxes_.subspan(whole.first, whole.count);
    // Always swaps, and advances if the swap was right: the branch could not be predicted.
    std::size_t below = 0;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const NumberedBox box = boxes[i];
        boxes[i] = boxes[below];
        boxes[below] = box;
        below += binning.bins_of(box.twice_centre())[wall.axis] < wall.bin ? 1 : 0;
    }
    return static_cast<std::uint32_t>(below);
}

std::uint32_t BoxSplitter::reorder_in_halves(const BoxRun &whole) const {
    const std::size_t axis = largest_lane(whole.twice_centres.upper - whole.twice_centres.lower);
    const std::span<NumberedBox> boxes = boxes_.subspan(whole.first, whole.count);
    const std::size_t half = boxes.size() / 2;
    std::ranges::nth_element(boxes, std::next(boxes.begin(), static_cast<std::ptrdiff_t>(half)),
                             [axis](const NumberedBox &a, const NumberedBox &b) {
                                 return a.twice_centre()[axis] < b.twice_centre()[axis];
                             });
    return static_cast<std::uint32_t>(half);
}

void BoxSplitter::split(BoxFork &fork, std::size_t index, SplitRule rule) const {
    const BoxRun whole = fork.runs[index];
    const Wall wall = rule == SplitRule::surface_area ? cheapest_wall(whole) : Wall{};
    const std::uint32_t below = wall.axis >= 0 ? reorder(whole, wall) : reorder_in_halves(whole);
    std::move_backward(fork.runs.begin() + index + 1, fork.runs.begin() + fork.size,
                       fork.runs.begin() + fork.size + 1);
    fork.runs[index] = run(whole.first, below);
    fork.runs[index + 1] = run(whole.first + below, whole.count - below);
    ++fork.size;
}

void BoxSplitter::open(BoxFork &fork, std::size_t index) const noexcept {
    const BoxRun whole = fork.runs[index];
    const std::size_t added = whole.count - 1;
    std::move_backward(fork.runs.begin() + index + 1, fork.runs.begin() + fork.size,
                       fork.runs.begin() + fork.size + added);
    for (std::uint32_t i = 0; i < whole.count; ++i) {
        fork.runs[index + i] = run(whole.first + i, 1);
    }
    fork.size += added;
}

/// From this depth on runs are halved by number, three times for each node, which ends well within
/// the 16 levels that remain: no more than 8^10 boxes can be numbered.
constexpr int kHalvingDepth = kDeepestBoxNode - 16;

/// The work is divided into at least this many parts, whatever the number of threads.
constexpr std::size_t kParts = 64;
constexpr std::uint32_t kMinPart = 1024;

/// For the comparison of areas, boxes grow by this share of the whole [-].
constexpr float kGapShare = 1e-5F;

[[nodiscard]] SplitRule rule_at(int depth) {
    return depth < kHalvingDepth ? SplitRule::surface_area : SplitRule::halves;
}

void set_lane(BoxNode &node, std::size_t lane, const Bounds &bounds, BoxChild child) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        node.walls_m[axis][lane / 4][lane % 4] = bounds.lower[axis];
        node.walls_m[axis + 3][lane / 4][lane % 4] = bounds.upper[axis];
    }
    node.children[lane] = child;
}

/// Adds a node for the run and all below it, in depth-first order. Returns its index.
std::uint32_t add_nodes(std::vector<BoxNode> &nodes, const BoxSplitter &splitter,
                        const BoxRun &whole, int depth) {
    const auto index = static_cast<std::uint32_t>(nodes.size());
    nodes.push_back(BoxNode::empty());
    const BoxFork fork = splitter.fork(whole, rule_at(depth));
    for (std::size_t lane = 0; lane < fork.size; ++lane) {
        const BoxRun &run = fork.runs[lane];
        const BoxChild child = run.count == 1
                                   ? BoxChild::item(run.first)
                                   : BoxChild::node(add_nodes(nodes, splitter, run, depth + 1));
        set_lane(nodes[index], lane, run.bounds, child);
    }
    return index;
}

/// A run that one thread turns into nodes, numbered from 0.
struct Part {
    BoxRun run;
    int depth = 0;
    std::vector<BoxNode> nodes;
    std::uint32_t offset = 0; ///< of the first node among all
};

enum class BranchKind : std::uint8_t { item, fork, part };

struct Branch {
    BranchKind kind = BranchKind::item;
    std::uint32_t index = 0;
};

/// A node near the root, whose runs are too large for one thread.
struct TopNode {
    BoxRun run;
    int depth = 0;
    BoxFork fork{};
    std::array<Branch, kBoxLanes> branches{};
    std::uint32_t offset = 0; ///< of this node among all
};

class Builder {
public:
    Builder(std::span<const Eigen::AlignedBox3d> boxes, unsigned threads)
        : threads_(threads), boxes_(boxes.size()),
          max_in_part_(std::max(kMinPart, static_cast<std::uint32_t>(boxes.size() / kParts))) {
        for_each_chunk([&](std::size_t i) {
            boxes_[i] = NumberedBox(boxes[i], static_cast<std::uint32_t>(i));
        });
    }

    [[nodiscard]] BoxTreeLayout take() {
        BoxSplitter splitter(boxes_, 0.0F);
        const BoxRun all = splitter.run(0, static_cast<std::uint32_t>(boxes_.size()));
        const Float4 size = all.bounds.upper - all.bounds.lower;
        splitter = BoxSplitter(boxes_, kGapShare * std::max({size[0], size[1], size[2]}));
        const Branch root = grow_top(splitter, all);
        for_each_in_parallel(parts_.size(), threads_, [&](std::size_t i) {
            Part &part = parts_[i];
            part.nodes.reserve(part.run.count / 4 + 1); // about a sixth is needed
            add_nodes(part.nodes, splitter, part.run, part.depth);
        });
        BoxTreeLayout layout;
        layout.order.resize(boxes_.size());
        for_each_chunk([&](std::size_t i) { layout.order[i] = boxes_[i].number(); });
        boxes_ = std::vector<NumberedBox>(); // no longer needed, and large
        std::size_t node_count = 0;
        place(root, node_count);
        layout.nodes.resize(node_count);
        assemble(layout.nodes);
        return layout;
    }

private:
    template <typename Work> void for_each_chunk(Work work) {
        constexpr std::size_t kChunk = 16384;
        for_each_in_parallel((boxes_.size() + kChunk - 1) / kChunk, threads_, [&](std::size_t c) {
            const std::size_t end = std::min(boxes_.size(), (c + 1) * kChunk);
            for (std::size_t i = c * kChunk; i < end; ++i) {
                work(i);
            }
        });
    }

    /// Divides level by level, all the runs of a level at a time, until every run is a part.
    Branch grow_top(const BoxSplitter &splitter, const BoxRun &all) {
        const Branch root = add_branch(all, 0);
        for (std::size_t begin = 0; begin < top_.size();) {
            const std::size_t end = top_.size();
            for_each_in_parallel(end - begin, threads_, [&](std::size_t i) {
                TopNode &node = top_[begin + i];
                node.fork = splitter.fork(node.run, rule_at(node.depth));
            });
            for (; begin < end; ++begin) {
                for (std::size_t lane = 0; lane < top_[begin].fork.size; ++lane) {
                    const Branch branch =
                        add_branch(top_[begin].fork.runs[lane], top_[begin].depth + 1);
                    top_[begin].branches[lane] = branch;
                }
            }
        }
        return root;
    }

    Branch add_branch(const BoxRun &run, int depth) {
        if (run.count == 1 && depth > 0) {
            return {BranchKind::item, run.first};
        }
        if (run.count <= max_in_part_) {
            parts_.push_back({run, depth, {}, 0});
            return {BranchKind::part, static_cast<std::uint32_t>(parts_.size() - 1)};
        }
        top_.push_back({run, depth});
        return {BranchKind::fork, static_cast<std::uint32_t>(top_.size() - 1)};
    }

    /// Assigns each node its index: a node, then all below its first branch, and so on.
    void place(const Branch &branch, std::size_t &next) {
        if (branch.kind == BranchKind::part) {
            Part &part = parts_[branch.index];
            part.offset = static_cast<std::uint32_t>(next);
            next += part.nodes.size();
        } else if (branch.kind == BranchKind::fork) {
            TopNode &node = top_[branch.index];
            node.offset = static_cast<std::uint32_t>(next++);
            for (std::size_t lane = 0; lane < node.fork.size; ++lane) {
                place(node.branches[lane], next);
            }
        }
    }

    [[nodiscard]] BoxChild placed(const Branch &branch) const {
        switch (branch.kind) {
        case BranchKind::fork:
            return BoxChild::node(top_[branch.index].offset);
        case BranchKind::part:
            return BoxChild::node(parts_[branch.index].offset);
        case BranchKind::item:
            break;
        }
        return BoxChild::item(branch.index);
    }

    void assemble(std::vector<BoxNode> &nodes) {
        for (const TopNode &top : top_) {
            BoxNode node = BoxNode::empty();
            for (std::size_t lane = 0; lane < top.fork.size; ++lane) {
                set_lane(node, lane, top.fork.runs[lane].bounds, placed(top.branches[lane]));
            }
            nodes[top.offset] = node;
        }
        for_each_in_parallel(parts_.size(), threads_, [&](std::size_t i) {
            Part &part = parts_[i];
            BoxNode *to = &nodes[part.offset];
            for (const BoxNode &node : part.nodes) {
                *to = node;
                for (BoxChild &child : to->children) {
                    child = child.is_item() ? child : BoxChild::node(child.index() + part.offset);
                }
                ++to;
            }
            part.nodes = std::vector<BoxNode>();
        });
    }

    unsigned threads_;
    std::vector<NumberedBox> boxes_;
    std::uint32_t max_in_part_;
    std::vector<TopNode> top_;
    std::vector<Part> parts_;
};

} // namespace

NumberedBox::NumberedBox(const Eigen::AlignedBox3d &box, std::uint32_t number) noexcept {
    SPRINGDRIVE_ASSERT(number < std::uint32_t{1} << 30U);
    const Vector3 &lower = box.min();
    const Vector3 &upper = box.max();
    bounds_.lower = Float4{rounded_down(lower.x()), rounded_down(lower.y()),
                           rounded_down(lower.z()), std::bit_cast<float>(number + kNumberOffset)};
    bounds_.upper =
        Float4{rounded_up(upper.x()), rounded_up(upper.y()), rounded_up(upper.z()), 0.0F};
}

std::uint32_t NumberedBox::number() const noexcept {
    return std::bit_cast<std::uint32_t>(static_cast<float>(bounds_.lower[3])) - kNumberOffset;
}

BoxTreeLayout lay_out_boxes(std::span<const Eigen::AlignedBox3d> boxes, unsigned threads) {
    SPRINGDRIVE_ASSERT(boxes.size() < std::size_t{1} << 30U);
    SPRINGDRIVE_ASSERT_AUDIT(std::ranges::all_of(boxes, [](const Eigen::AlignedBox3d &box) {
        return !box.isEmpty() && box.min().allFinite() && box.max().allFinite();
    }));
    return boxes.empty() ? BoxTreeLayout{} : Builder(boxes, threads).take();
}

BoxTree::BoxTree(std::span<const Eigen::AlignedBox3d> boxes, unsigned threads)
    : layout_(lay_out_boxes(boxes, threads)) {}

} // namespace springdrive::contact
