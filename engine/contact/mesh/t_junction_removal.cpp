#include "engine/contact/mesh/mesh_stitching.h"

#include "base/assertions.h"
#include "base/parallel.h"
#include "engine/contact/mesh/point_tree.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <tuple>
#include <unordered_set>

namespace springdrive::contact {

namespace {

/// More vertices per tolerance of an edge's length than this are not a T-junction but a mesh finer
/// than the tolerance, and are left unchanged.
constexpr double kMaxPerTolerance = 4.0;
constexpr double kMaxPerEdge = 16.0;

/// Where a vertex divides a side of a triangle.
struct Cut {
    std::uint32_t triangle = 0;
    std::uint32_t side = 0;
    double fraction = 0.0;
    std::uint32_t vertex = 0;
    double distance_m = 0.0;
};

[[nodiscard]] bool has_corner(const MeshTriangle &triangle, std::uint32_t vertex) {
    return std::ranges::find(triangle.vertices, vertex) != triangle.vertices.end();
}

class CutFinder {
public:
    CutFinder(const std::vector<MeshTriangle> &triangles, const EdgeTable &edges,
              const std::vector<Vector3> &vertices_m, double tolerance_m, unsigned threads)
        : triangles_(triangles), vertices_m_(vertices_m), tolerance_m_(tolerance_m),
          rim_(triangles, edges, vertices_m), tree_(rim_.places_m(), threads) {}

    /// Returns the steps that it took and that dividing by these cuts will take.
    std::uint64_t append_cuts(const EdgeUse &use, std::vector<Cut> &cuts) const {
        const MeshTriangle &triangle = triangles_[use.triangle()];
        const Vector3 &from_m = vertices_m_[triangle.vertices[use.side()]];
        const Vector3 &to_m = vertices_m_[triangle.vertices[(use.side() + 1) % 3]];
        const std::size_t before = cuts.size();
        const double maximum =
            kMaxPerEdge + kMaxPerTolerance * (to_m - from_m).norm() / tolerance_m_;
        const auto is_one_too_many = [&](std::uint32_t number, double fraction, double distance_m) {
            const std::uint32_t vertex = rim_.vertex(number);
            if (!has_corner(triangle, vertex)) {
                cuts.push_back({use.triangle(), use.side(), fraction, vertex, distance_m});
            }
            return static_cast<double>(cuts.size() - before) > maximum;
        };
        const std::uint64_t compared =
            tree_.visit_along(from_m, to_m, tolerance_m_, is_one_too_many);
        if (static_cast<double>(cuts.size() - before) > maximum) {
            cuts.resize(before);
        }
        return kStepsPerNode * compared + kStepsPerPiece * (cuts.size() - before);
    }

private:
    const std::vector<MeshTriangle> &triangles_;
    const std::vector<Vector3> &vertices_m_;
    double tolerance_m_;
    BoundaryVertices rim_;
    PointTree tree_;
};

[[noreturn]] void refuse_cuts(const CutFinder &finder, const EdgeTable &edges,
                              std::uint64_t taken_before, const PreparationAllowance &allowance) {
    std::vector<EdgeUse> open;
    edges.for_each([&](const Edge &edge) {
        if (edge.is_open()) {
            open.push_back(edge.uses.front());
        }
    });
    std::vector<Cut> cuts;
    const double needed = estimated_steps(open.size(), [&](std::size_t i) {
        cuts.clear();
        return finder.append_cuts(open[i], cuts);
    });
    allowance.refuse("divide triangles where vertices of others touch their edges",
                     static_cast<double>(taken_before) + needed);
}

[[nodiscard]] bool is_before(const Cut &a, const Cut &b) {
    return std::tie(a.triangle, a.side, a.fraction, a.vertex) <
           std::tie(b.triangle, b.side, b.fraction, b.vertex);
}

/// All cuts, those of one triangle next to each other, side by side and along each side.
[[nodiscard]] std::vector<Cut> find_cuts(const CutFinder &finder, const EdgeTable &edges,
                                         PreparationAllowance &allowance, unsigned threads) {
    const std::uint64_t taken_before = allowance.taken();
    std::vector<std::vector<Cut>> cuts_of_chunk(threads);
    in_chunks(edges.vertices(), threads, [&](unsigned chunk, std::size_t first, std::size_t last) {
        std::vector<Cut> &cuts = cuts_of_chunk[chunk];
        StepCounter steps(allowance);
        bool is_allowed = true;
        edges.for_each(first, last, [&](const Edge &edge) {
            if (edge.is_open() && is_allowed) {
                is_allowed = steps.add(finder.append_cuts(edge.uses.front(), cuts));
            }
        });
        if (is_allowed) {
            std::ranges::sort(cuts, is_before);
        }
    });
    if (allowance.is_exceeded()) {
        refuse_cuts(finder, edges, taken_before, allowance);
    }
    std::vector<Cut> cuts;
    for (std::vector<Cut> &some : cuts_of_chunk) {
        const auto sorted = static_cast<std::ptrdiff_t>(cuts.size());
        cuts.insert(cuts.end(), some.begin(), some.end());
        some = {};
        std::inplace_merge(cuts.begin(), cuts.begin() + sorted, cuts.end(), is_before);
    }
    return cuts;
}

/// The pieces of one triangle while it is being divided.
class Pieces {
public:
    explicit Pieces(const VertexTriple &whole) : pieces_{whole} {}

    /// Divides the piece with the side `from`–`to` into a fan about its opposite corner.
    void divide(std::uint32_t from, std::uint32_t to, std::span<const Cut> cuts) {
        for (const Cut &cut : cuts) {
            // A vertex that cuts two sides would make a piece with that vertex twice.
            if (cutters_.insert(cut.vertex).second) {
                divide_once(from, to, cut.vertex);
                from = cut.vertex;
            }
        }
    }

    [[nodiscard]] const std::vector<VertexTriple> &all() const { return pieces_; }

private:
    void divide_once(std::uint32_t from, std::uint32_t to, std::uint32_t vertex) {
        // The piece to divide is mostly the one made last.
        for (std::size_t i = pieces_.size(); i-- > 0;) {
            for (std::size_t side = 0; side < 3; ++side) {
                if (pieces_[i][side] == from && pieces_[i][(side + 1) % 3] == to) {
                    const std::uint32_t apex = pieces_[i][(side + 2) % 3];
                    pieces_[i] = {from, vertex, apex};
                    pieces_.push_back({vertex, to, apex});
                    return;
                }
            }
        }
    }

    std::vector<VertexTriple> pieces_;
    std::unordered_set<std::uint32_t> cutters_;
};

} // namespace

SplitEdges split_edges(std::vector<MeshTriangle> &triangles, const EdgeTable &edges,
                       const std::vector<Vector3> &vertices_m, double tolerance_m,
                       PreparationAllowance &allowance, unsigned threads) {
    SPRINGDRIVE_ASSERT(tolerance_m > 0.0 && threads > 0);
    const CutFinder finder(triangles, edges, vertices_m, tolerance_m, threads);
    const std::vector<Cut> cuts = find_cuts(finder, edges, allowance, threads);
    SplitEdges split;
    for (auto first = cuts.begin(); first != cuts.end();) {
        const std::uint32_t index = first->triangle;
        const MeshTriangle whole = triangles[index];
        Pieces pieces(whole.vertices);
        while (first != cuts.end() && first->triangle == index) {
            const std::uint32_t side = first->side;
            const auto last = std::find_if(first, cuts.end(), [&](const Cut &cut) {
                return cut.triangle != index || cut.side != side;
            });
            pieces.divide(whole.vertices[side], whole.vertices[(side + 1) % 3], {first, last});
            first = last;
        }
        for (std::size_t i = 0; i < pieces.all().size(); ++i) {
            const MeshTriangle piece{pieces.all()[i], whole.triangle, whole.has_both_windings};
            if (i == 0) {
                triangles[index] = piece;
            } else {
                triangles.push_back(piece);
            }
        }
        ++split.split_triangles;
    }
    for (const Cut &cut : cuts) {
        split.largest_move_m = std::max(split.largest_move_m, cut.distance_m);
    }
    return split;
}

} // namespace springdrive::contact
