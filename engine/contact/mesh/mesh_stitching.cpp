#include "engine/contact/mesh/mesh_stitching.h"

#include "base/assertions.h"
#include "base/cancellation.h"
#include "base/input_error.h"
#include "base/parallel.h"
#include "engine/contact/mesh/vertex_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <string>
#include <tuple>
#include <unordered_set>
#include <utility>

namespace springdrive::contact {

namespace {

[[nodiscard]] std::string in_millions(double steps) {
    return std::to_string(std::llround(steps / 1e6)) + " million";
}

} // namespace

void PreparationAllowance::refuse(std::string_view purpose, double needed_steps) const {
    const auto allowed = static_cast<double>(allowed_);
    throw InputError(
        "preparing its " + std::to_string(triangles_) + " triangles for touch needs " +
        (needed_steps > allowed ? "about " + in_millions(needed_steps)
                                : "more than " + in_millions(allowed)) +
        " steps, most of them to " + std::string(purpose) + "; at most " + in_millions(allowed) +
        " are allowed: join vertices that nearly coincide, remove triangles that lie on top of "
        "each other, or enlarge it");
}

namespace {

/// Cell size in tolerances: large enough that a vertex rarely lies near the wall of its cell and
/// needs its neighbours searched, small enough that a cell holds few vertices.
constexpr double kCellTolerances = 16.0;

} // namespace

std::vector<std::uint32_t> weld_vertices(const std::vector<Vector3> &vertices_m, double tolerance_m,
                                         PreparationAllowance &allowance, unsigned threads) {
    SPRINGDRIVE_ASSERT(tolerance_m > 0.0 && threads > 0);
    const auto count = static_cast<std::uint32_t>(vertices_m.size());
    VertexGrid grid(vertices_m, tolerance_m, kCellTolerances * tolerance_m, threads);
    std::vector<std::uint32_t> stands_for(count);
    std::uint32_t vertex = 0;
    {
        StepCounter steps(allowance);
        for (bool is_allowed = true; is_allowed && vertex < count; ++vertex) {
            stop_if_given_up(vertex);
            grid.prefetch(std::min(vertex + VertexGrid::kAhead, count - 1));
            stands_for[vertex] = vertex;
            if (!vertices_m[vertex].allFinite()) {
                continue;
            }
            const std::uint64_t compared = grid.visit_earlier(vertex, [&](std::uint32_t earlier) {
                stands_for[vertex] = earlier;
                return true;
            });
            if (stands_for[vertex] == vertex) {
                grid.insert(vertex);
            }
            is_allowed = steps.add(compared);
        }
    }
    if (allowance.is_exceeded()) {
        allowance.refuse("find vertices at the same place",
                         static_cast<double>(allowance.taken()) * count / vertex);
    }
    return stands_for;
}

namespace {

/// Distances are sorted into this many classes: the nearest first to a sixty-fourth of the
/// tolerance.
constexpr std::size_t kDistanceClasses = 64;

/// No more neighbours of a vertex than this are examined: where more are within the tolerance, they
/// are connected through each other anyway, or the mesh is finer than the tolerance.
constexpr int kMaxNeighbours = 64;

/// From here on vertices are identified by their numbers in the rim.
struct NearPair {
    std::uint32_t a = 0;
    std::uint32_t b = 0;
};

/// Finds the pairs of vertices within the tolerance, up to kMaxNeighbours for each vertex.
class PairFinder {
public:
    PairFinder(const std::vector<Vector3> &places_m, double tolerance_m, unsigned threads)
        : places_m_(places_m), tolerance_m_(tolerance_m), threads_(threads),
          grid_(places_m, tolerance_m, 8.0 * tolerance_m, threads) {
        grid_.insert_all(threads);
    }

    /// All pairs, the nearest first, then in the order of their higher vertices.
    [[nodiscard]] std::vector<NearPair> pairs(PreparationAllowance &allowance) const {
        const std::uint64_t taken_before = allowance.taken();
        std::vector<Found> found_by(threads_);
        in_chunks(places_m_.size(), threads_,
                  [&](unsigned chunk, std::size_t first, std::size_t last) {
                      find(first, last, allowance, found_by[chunk]);
                  });
        if (allowance.is_exceeded()) {
            const double needed = estimated_steps(places_m_.size(), [&](std::size_t vertex) {
                std::uint64_t pairs = 0;
                const std::uint64_t compared =
                    visit_neighbours(static_cast<std::uint32_t>(vertex),
                                     [&pairs](std::uint32_t, double) { ++pairs; });
                return compared + kStepsPerPair * pairs;
            });
            allowance.refuse("find vertices that nearly coincide",
                             static_cast<double>(taken_before) + needed);
        }
        return sorted(found_by);
    }

private:
    struct Found {
        std::vector<NearPair> pairs;
        std::vector<std::uint8_t> distance_classes;                ///< of the pairs
        std::array<std::size_t, kDistanceClasses> next_of_class{}; ///< first their number
    };

    /// Calls `visit(earlier, distance_m)`. Returns how many vertices were compared.
    template <typename Visit>
    [[nodiscard]] std::uint64_t visit_neighbours(std::uint32_t vertex, const Visit &visit) const {
        int neighbours = 0;
        return grid_.visit_earlier(vertex, [&](std::uint32_t earlier) {
            visit(earlier, (places_m_[vertex] - places_m_[earlier]).norm());
            return ++neighbours == kMaxNeighbours;
        });
    }

    void find(std::size_t first, std::size_t last, PreparationAllowance &allowance,
              Found &found) const {
        StepCounter steps(allowance);
        for (std::size_t i = first; i < last; ++i) {
            stop_if_given_up(i);
            const auto vertex = static_cast<std::uint32_t>(i);
            grid_.prefetch(
                static_cast<std::uint32_t>(std::min(i + VertexGrid::kAhead, places_m_.size() - 1)));
            const std::size_t before = found.pairs.size();
            const std::uint64_t compared =
                visit_neighbours(vertex, [&](std::uint32_t earlier, double distance_m) {
                    const double share = distance_m / tolerance_m_;
                    const auto distance_class = static_cast<std::uint8_t>(
                        std::min(kDistanceClasses - 1.0, std::floor(share * kDistanceClasses)));
                    found.pairs.push_back({earlier, vertex});
                    found.distance_classes.push_back(distance_class);
                    ++found.next_of_class[distance_class];
                });
            if (!steps.add(compared + kStepsPerPair * (found.pairs.size() - before))) {
                return;
            }
        }
    }

    [[nodiscard]] std::vector<NearPair> sorted(std::vector<Found> &found_by) const {
        std::size_t total = 0;
        for (std::size_t distance_class = 0; distance_class < kDistanceClasses; ++distance_class) {
            for (Found &found : found_by) {
                total += std::exchange(found.next_of_class[distance_class], total);
            }
        }
        std::vector<NearPair> pairs(total);
        in_chunks(found_by.size(), threads_, [&](unsigned chunk, std::size_t, std::size_t) {
            Found &found = found_by[chunk];
            for (std::size_t i = 0; i < found.pairs.size(); ++i) {
                stop_if_given_up(i);
                pairs[found.next_of_class[found.distance_classes[i]]++] = found.pairs[i];
            }
        });
        return pairs;
    }

    const std::vector<Vector3> &places_m_;
    double tolerance_m_;
    unsigned threads_;
    VertexGrid grid_;
};

/// Vertices that become one, each cluster at the place of its head.
class Clusters {
public:
    Clusters(const BoundaryVertices &rim, const std::vector<MeshTriangle> &triangles,
             double tolerance_m)
        : rim_(rim), triangles_(triangles), tolerance_m_(tolerance_m), head_(rim.size()),
          next_(rim.size()), size_(rim.size(), 1), uses_(rim.size()) {
        std::iota(head_.begin(), head_.end(), 0U);
        std::iota(next_.begin(), next_.end(), 0U);
        for (std::uint32_t vertex = 0; vertex < rim.size(); ++vertex) {
            uses_[vertex] = static_cast<std::uint32_t>(rim.triangles_at(vertex).size());
        }
    }

    /// Joins the smaller cluster to the larger, if that is allowed. Returns the steps it took.
    std::uint64_t join(std::uint32_t a, std::uint32_t b) {
        steps_ = 1;
        std::uint32_t into = head_[a];
        std::uint32_t from = head_[b];
        if (into == from) {
            return steps_;
        }
        if (std::pair(size_[into], from) < std::pair(size_[from], into)) {
            std::swap(into, from);
        }
        if (!may_join(from, into)) {
            return steps_;
        }
        steps_ += size_[from];
        size_[into] += size_[from];
        uses_[into] += uses_[from];
        for_each_member(from, [&](std::uint32_t member) {
            head_[member] = into;
            return true;
        });
        std::swap(next_[into], next_[from]);
        return steps_;
    }

    [[nodiscard]] std::uint32_t head_of(std::uint32_t vertex) const { return head_[vertex]; }

private:
    /// Calls `visit(member)` until it returns false. Returns whether it never did.
    template <typename Visit> bool for_each_member(std::uint32_t head, const Visit &visit) const {
        std::uint32_t member = head;
        do {
            if (!visit(member)) {
                return false;
            }
            member = next_[member];
        } while (member != head);
        return true;
    }

    [[nodiscard]] bool may_join(std::uint32_t from, std::uint32_t into) {
        // Clusters only grow: what keeps these two apart once always does.
        const std::uint64_t both = std::uint64_t{from} << 32 | into;
        if (kept_apart_.contains(both)) {
            return false;
        }
        if (is_within_tolerance(from, into) && !share_triangle(from, into)) {
            return true;
        }
        if (steps_ > kStepsToRemember) {
            kept_apart_.insert(both);
        }
        return false;
    }

    [[nodiscard]] bool is_within_tolerance(std::uint32_t from, std::uint32_t into) {
        return for_each_member(from, [&](std::uint32_t member) {
            ++steps_;
            return (rim_.place_m(member) - rim_.place_m(into)).norm() <= tolerance_m_;
        });
    }

    [[nodiscard]] bool share_triangle(std::uint32_t a, std::uint32_t b) {
        if (uses_[b] < uses_[a]) {
            std::swap(a, b);
        }
        return !for_each_member(a, [&](std::uint32_t member) {
            steps_ += 1 + rim_.triangles_at(member).size();
            return std::ranges::none_of(rim_.triangles_at(member), [&](std::uint32_t triangle) {
                return std::ranges::any_of(
                    triangles_[triangle].vertices, [&](std::uint32_t corner) {
                        return rim_.has(corner) && head_[rim_.number_of(corner)] == b;
                    });
            });
        });
    }

    /// It takes about as long to remember a refusal.
    static constexpr std::uint64_t kStepsToRemember = 32;

    const BoundaryVertices &rim_;
    const std::vector<MeshTriangle> &triangles_;
    double tolerance_m_;
    std::vector<std::uint32_t> head_;
    std::vector<std::uint32_t> next_; ///< the members of a cluster, in a ring
    std::vector<std::uint32_t> size_; ///< of heads
    std::vector<std::uint32_t> uses_; ///< by triangles, of heads
    std::unordered_set<std::uint64_t> kept_apart_;
    std::uint64_t steps_ = 0; ///< of the present join
};

void join_all(Clusters &clusters, const std::vector<NearPair> &pairs,
              PreparationAllowance &allowance) {
    const std::uint64_t taken_before = allowance.taken();
    std::size_t done = 0;
    {
        StepCounter steps(allowance);
        for (bool is_allowed = true; is_allowed && done < pairs.size(); ++done) {
            stop_if_given_up(done);
            is_allowed = steps.add(clusters.join(pairs[done].a, pairs[done].b));
        }
    }
    if (allowance.is_exceeded()) {
        const double share = static_cast<double>(done) / static_cast<double>(pairs.size());
        allowance.refuse("join vertices that nearly coincide",
                         static_cast<double>(taken_before) +
                             static_cast<double>(allowance.taken() - taken_before) / share);
    }
}

} // namespace

ClosedCracks close_cracks(const std::vector<MeshTriangle> &triangles, const EdgeTable &edges,
                          const std::vector<Vector3> &vertices_m, double tolerance_m,
                          PreparationAllowance &allowance, unsigned threads) {
    SPRINGDRIVE_ASSERT(tolerance_m > 0.0 && threads > 0);
    ClosedCracks closed;
    closed.stands_for.resize(vertices_m.size());
    std::iota(closed.stands_for.begin(), closed.stands_for.end(), 0U);

    const BoundaryVertices rim(triangles, edges, vertices_m);
    Clusters clusters(rim, triangles, tolerance_m);
    join_all(clusters, PairFinder(rim.places_m(), tolerance_m, threads).pairs(allowance),
             allowance);
    for (std::uint32_t i = 0; i < rim.size(); ++i) {
        const std::uint32_t head = clusters.head_of(i);
        if (head != i) {
            closed.stands_for[rim.vertex(i)] = rim.vertex(head);
            ++closed.moved_vertices;
            closed.largest_move_m =
                std::max(closed.largest_move_m, (rim.place_m(i) - rim.place_m(head)).norm());
        }
    }
    return closed;
}

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
