#include "engine/contact/bvh/box_tree_build.h"

#include "base/assertions.h"
#include "base/parallel.h"
#include "engine/contact/bvh/box_split.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace springdrive::contact {

namespace {

/// From this depth on runs are halved in number, three times for each node, which ends well within
/// the 16 levels that remain: 8^10 boxes are all that can be numbered.
constexpr int kHalvingDepth = kDeepestBoxNode - 16;

/// Work is shared in so many parts or more, whatever the number of threads.
constexpr std::size_t kParts = 64;
constexpr std::uint32_t kLeastPart = 1024;

/// Where areas are compared, boxes are larger by this share of all [-].
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

/// Adds a node for the run and all below it, in the order of a walk. Returns its index.
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

/// A node near the root, whose runs are too large to be left to one thread.
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
          most_in_part_(std::max(kLeastPart, static_cast<std::uint32_t>(boxes.size() / kParts))) {
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
            part.nodes.reserve(part.run.count / 4 + 1); // about a sixth is what it takes
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
        if (run.count <= most_in_part_) {
            parts_.push_back({run, depth, {}, 0});
            return {BranchKind::part, static_cast<std::uint32_t>(parts_.size() - 1)};
        }
        top_.push_back({run, depth});
        return {BranchKind::fork, static_cast<std::uint32_t>(top_.size() - 1)};
    }

    /// Gives each node its place: a node, then all below its first branch, and so on.
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
    std::uint32_t most_in_part_;
    std::vector<TopNode> top_;
    std::vector<Part> parts_;
};

} // namespace

BoxTreeLayout lay_out_boxes(std::span<const Eigen::AlignedBox3d> boxes, unsigned threads) {
    SPRINGDRIVE_ASSERT(boxes.size() < std::size_t{1} << 30U);
    SPRINGDRIVE_ASSERT_AUDIT(std::ranges::all_of(boxes, [](const Eigen::AlignedBox3d &box) {
        return !box.isEmpty() && box.min().allFinite() && box.max().allFinite();
    }));
    return boxes.empty() ? BoxTreeLayout{} : Builder(boxes, threads).take();
}

} // namespace springdrive::contact
