#include "engine/contact/mesh/repeated_triangles.h"

#include "base/parallel.h"

#include <algorithm>
#include <span>
#include <tuple>

namespace springdrive::contact {

namespace {

/// A triangle seen from the edge between its two lowest vertices.
struct Leaf {
    std::uint32_t opposite = 0; ///< its third vertex
    std::uint32_t index = 0;    ///< among the triangles of the mesh
    bool is_forward = true;
};

/// What becomes of repeated triangles, by their indices in the mesh.
struct Verdict {
    std::vector<std::uint32_t> to_drop;
    std::vector<std::uint32_t> to_merge;          ///< to drop: the other side of one that is kept
    std::vector<std::uint32_t> has_both_windings; ///< kept, for two sides
};

class RepeatFinder {
public:
    RepeatFinder(const std::vector<MeshTriangle> &triangles,
                 const std::vector<std::uint16_t> &material_of_triangle)
        : triangles_(triangles), material_of_triangle_(material_of_triangle) {}

    /// Every group of equal triangles is found at one edge only, that between its lowest vertices.
    void look_at(const Edge &edge) {
        if (edge.is_open()) {
            return;
        }
        leaves_.clear();
        for (const EdgeUse &use : edge.uses) {
            const std::uint32_t opposite =
                triangles_[use.triangle()].vertices[(use.side() + 2) % 3];
            if (opposite > edge.upper()) {
                leaves_.push_back({opposite, use.triangle(), use.is_forward()});
            }
        }
        if (leaves_.size() < 2 ||
            (leaves_.size() == 2 && leaves_[0].opposite != leaves_[1].opposite)) {
            return;
        }
        std::ranges::sort(leaves_, [](const Leaf &a, const Leaf &b) {
            return std::tie(a.opposite, a.index) < std::tie(b.opposite, b.index);
        });
        for (auto first = leaves_.begin(); first != leaves_.end();) {
            const auto last = std::find_if(first, leaves_.end(), [first](const Leaf &leaf) {
                return leaf.opposite != first->opposite;
            });
            judge({first, last});
            first = last;
        }
    }

    [[nodiscard]] const Verdict &verdict() const { return verdict_; }

private:
    /// Of equal triangles, in ascending order.
    void judge(std::span<const Leaf> equal) {
        const Leaf &kept = equal.front();
        bool has_both = std::ranges::any_of(
            equal, [this](const Leaf &leaf) { return triangles_[leaf.index].has_both_windings; });
        bool has_other_side = has_both;
        for (const Leaf &leaf : equal.subspan(1)) {
            if (leaf.is_forward == kept.is_forward || has_other_side) {
                verdict_.to_drop.push_back(leaf.index);
                continue;
            }
            has_other_side = true;
            if (material(leaf) == material(kept)) {
                verdict_.to_merge.push_back(leaf.index);
                has_both = true;
            }
        }
        if (has_both) {
            verdict_.has_both_windings.push_back(kept.index);
        }
    }

    [[nodiscard]] std::uint16_t material(const Leaf &leaf) const {
        return material_of_triangle_[triangles_[leaf.index].triangle];
    }

    const std::vector<MeshTriangle> &triangles_;
    const std::vector<std::uint16_t> &material_of_triangle_;
    std::vector<Leaf> leaves_;
    Verdict verdict_;
};

} // namespace

RepeatedTriangles drop_repeated_triangles(std::vector<MeshTriangle> &triangles,
                                          const EdgeTable &edges,
                                          const std::vector<std::uint16_t> &material_of_triangle,
                                          unsigned threads) {
    std::vector<Verdict> verdicts(threads);
    in_chunks(edges.vertices(), threads, [&](unsigned chunk, std::size_t first, std::size_t last) {
        RepeatFinder finder(triangles, material_of_triangle);
        edges.for_each(first, last, [&finder](const Edge &edge) { finder.look_at(edge); });
        verdicts[chunk] = finder.verdict();
    });

    RepeatedTriangles repeated;
    std::vector<std::uint32_t> to_drop;
    for (const Verdict &verdict : verdicts) {
        for (const std::uint32_t index : verdict.to_drop) {
            repeated.same_winding.push_back(triangles[index].triangle);
            to_drop.push_back(index);
        }
        for (const std::uint32_t index : verdict.to_merge) {
            repeated.merged.push_back(triangles[index].triangle);
            to_drop.push_back(index);
        }
        for (const std::uint32_t index : verdict.has_both_windings) {
            triangles[index].has_both_windings = true;
        }
    }
    if (to_drop.empty()) {
        return repeated;
    }
    std::vector<bool> is_dropped(triangles.size(), false);
    for (const std::uint32_t index : to_drop) {
        is_dropped[index] = true;
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        if (!is_dropped[i]) {
            triangles[kept++] = triangles[i];
        }
    }
    triangles.resize(kept);
    return repeated;
}

} // namespace springdrive::contact
