#include "engine/contact/mesh/mesh_stitching.h"

#include "base/assertions.h"
#include "base/cancellation.h"
#include "base/parallel.h"
#include "engine/contact/mesh/vertex_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_set>
#include <utility>

namespace springdrive::contact {

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

} // namespace springdrive::contact
