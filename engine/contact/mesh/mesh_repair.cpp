#include "engine/contact/mesh/mesh_repair.h"

#include "base/cancellation.h"
#include "base/parallel.h"
#include "engine/contact/mesh/mesh_topology.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <tuple>
#include <utility>

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

constexpr double kClearMajority = 2.0 / 3.0;

/// Volumes below this times area^1.5 are round-off: a foil of 10 µm, 10 cm square, has 1e-4 of it.
constexpr double kMinVolumeRatio = 1e-9;

/// What decides which way a patch is turned.
struct Patch {
    bool is_orientable = true;
    double area = 0.0;                ///< twice the area, as all areas here [m²]
    double area_of_first = 0.0;       ///< wound as the patch's first triangle, of one winding only
    double area_of_others = 0.0;      ///< wound the other way, of one winding only
    Vector3 moment = Vector3::Zero(); ///< area times place [m³]
    double volume = 0.0; ///< six times the volume up to the middle, wound as the first triangle
                         ///< [m³]

    [[nodiscard]] double voting_area() const { return area_of_first + area_of_others; }

    [[nodiscard]] bool is_first_right() const {
        const double larger = std::max(area_of_first, area_of_others);
        const bool has_inside = std::abs(volume) > kMinVolumeRatio * std::pow(area, 1.5);
        if (larger < kClearMajority * voting_area() && has_inside) {
            return volume > 0.0;
        }
        return area_of_first >= area_of_others;
    }
};

class Orientation {
public:
    Orientation(std::vector<MeshTriangle> &triangles, const std::vector<Vector3> &vertices_m)
        : triangles_(triangles), vertices_m_(vertices_m), sets_(triangles.size()),
          patch_of_root_(triangles.size()) {}

    void connect(const EdgeTable &edges) {
        std::vector<std::uint32_t> at_odds;
        edges.for_each([&](const Edge &edge) {
            if (edge.is_manifold() && !sets_.unite(edge.uses[0].triangle(), edge.uses[1].triangle(),
                                                   edge.is_run_twice_the_same_way())) {
                at_odds.push_back(edge.uses[0].triangle());
            }
        });
        for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
            if (sets_.root_of(i) == i) {
                patch_of_root_[i] = static_cast<std::uint32_t>(patches_.size());
                patches_.emplace_back();
            }
        }
        for (const std::uint32_t triangle : at_odds) {
            patches_[patch_of_root_[sets_.root_of(triangle)]].is_orientable = false;
        }
    }

    void collect_votes() {
        for_each([&](const MeshTriangle &triangle, Patch &patch, bool is_opposite) {
            const auto [a, b, c] = corners_m(triangle);
            const double area = (b - a).cross(c - a).norm();
            patch.area += area;
            patch.moment += area / 3.0 * (a + b + c);
            if (!triangle.has_both_windings) {
                (is_opposite ? patch.area_of_others : patch.area_of_first) += area;
            }
        });
        for_each([&](const MeshTriangle &triangle, Patch &patch, bool is_opposite) {
            const auto [a, b, c] = corners_m(triangle);
            const Vector3 middle_m = patch.moment / patch.area;
            const double volume = (a - middle_m).dot((b - middle_m).cross(c - middle_m));
            patch.volume += is_opposite ? -volume : volume;
        });
    }

    TurnedTriangles turn() {
        std::vector<bool> is_first_right;
        for (const Patch &patch : patches_) {
            is_first_right.push_back(patch.is_first_right());
        }
        TurnedTriangles turned;
        for_each([&](MeshTriangle &triangle, const Patch &patch, bool is_opposite) {
            const auto number = static_cast<std::size_t>(&patch - patches_.data());
            if (patch.is_orientable && is_opposite == is_first_right[number]) {
                std::swap(triangle.vertices[1], triangle.vertices[2]);
                ++(triangle.has_both_windings ? turned.of_both : turned.of_one_winding);
            }
        });
        return turned;
    }

private:
    template <typename Visit> void for_each(Visit visit) {
        for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
            stop_if_given_up(i);
            const TriangleSets::Place place = sets_.place_of(i);
            visit(triangles_[i], patches_[patch_of_root_[place.root]], place.is_opposite);
        }
    }

    [[nodiscard]] std::array<Vector3, 3> corners_m(const MeshTriangle &triangle) const {
        const auto &[a, b, c] = triangle.vertices;
        return {vertices_m_[a], vertices_m_[b], vertices_m_[c]};
    }

    std::vector<MeshTriangle> &triangles_;
    const std::vector<Vector3> &vertices_m_;
    TriangleSets sets_;
    std::vector<std::uint32_t> patch_of_root_;
    std::vector<Patch> patches_;
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

TurnedTriangles orient_triangles(std::vector<MeshTriangle> &triangles, const EdgeTable &edges,
                                 const std::vector<Vector3> &vertices_m) {
    bool is_consistent = true;
    edges.for_each([&](const Edge &edge) {
        is_consistent = is_consistent && !edge.is_run_twice_the_same_way();
    });
    if (is_consistent) {
        return {};
    }
    Orientation orientation(triangles, vertices_m);
    orientation.connect(edges);
    orientation.collect_votes();
    return orientation.turn();
}

} // namespace springdrive::contact
