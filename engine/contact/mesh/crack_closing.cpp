#include "engine/contact/mesh/crack_closing.h"

#include "base/assertions.h"
#include "engine/contact/mesh/rim.h"
#include "engine/contact/mesh/vertex_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
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
    std::uint32_t distance_class = 0;
};

/// All pairs within the tolerance, up to kMaxNeighbours for each vertex; the nearest first.
[[nodiscard]] std::vector<NearPair> near_pairs(const std::vector<Vector3> &places_m,
                                               double tolerance_m) {
    VertexGrid grid(places_m, tolerance_m, 8.0 * tolerance_m);
    std::vector<NearPair> pairs;
    for (std::uint32_t vertex = 0; vertex < places_m.size(); ++vertex) {
        const VertexGrid::Home home = grid.home_of(vertex);
        int neighbours = 0;
        const auto note = [&](std::uint32_t earlier) {
            const double share = (places_m[vertex] - places_m[earlier]).norm() / tolerance_m;
            const auto distance_class = static_cast<std::uint32_t>(
                std::min(kDistanceClasses - 1.0, std::floor(share * kDistanceClasses)));
            pairs.push_back({earlier, vertex, distance_class});
            return ++neighbours == kMaxNeighbours;
        };
        static_cast<void>(grid.visit_near(vertex, home, note));
        grid.insert(vertex, home);
    }

    std::array<std::size_t, kDistanceClasses + 1> first_of_class{};
    for (const NearPair &pair : pairs) {
        ++first_of_class[pair.distance_class + 1];
    }
    std::partial_sum(first_of_class.begin(), first_of_class.end(), first_of_class.begin());
    std::vector<NearPair> sorted(pairs.size());
    for (const NearPair &pair : pairs) {
        sorted[first_of_class[pair.distance_class]++] = pair;
    }
    return sorted;
}

/// Vertices that become one, each cluster at the place of its head.
class Clusters {
public:
    Clusters(const Rim &rim, const std::vector<MeshTriangle> &triangles, double tolerance_m)
        : rim_(rim), triangles_(triangles), tolerance_m_(tolerance_m), head_(rim.size()),
          next_(rim.size()), size_(rim.size(), 1) {
        std::iota(head_.begin(), head_.end(), 0U);
        std::iota(next_.begin(), next_.end(), 0U);
    }

    /// Joins the smaller cluster to the larger, if that is allowed.
    void join(std::uint32_t a, std::uint32_t b) {
        std::uint32_t into = head_[a];
        std::uint32_t from = head_[b];
        if (into == from) {
            return;
        }
        if (std::pair(size_[into], from) < std::pair(size_[from], into)) {
            std::swap(into, from);
        }
        if (!may_join(from, into)) {
            return;
        }
        size_[into] += size_[from];
        for_each_member(from, [&](std::uint32_t member) { head_[member] = into; });
        std::swap(next_[into], next_[from]);
    }

    [[nodiscard]] std::uint32_t head_of(std::uint32_t vertex) const { return head_[vertex]; }

private:
    template <typename Visit> void for_each_member(std::uint32_t head, Visit visit) const {
        std::uint32_t member = head;
        do {
            visit(member);
            member = next_[member];
        } while (member != head);
    }

    [[nodiscard]] bool may_join(std::uint32_t from, std::uint32_t into) const {
        bool may = true;
        for_each_member(from, [&](std::uint32_t member) {
            may = may && (rim_.place_m(member) - rim_.place_m(into)).norm() <= tolerance_m_ &&
                  !shares_triangle(member, into);
        });
        return may;
    }

    [[nodiscard]] bool shares_triangle(std::uint32_t vertex, std::uint32_t cluster) const {
        return std::ranges::any_of(rim_.triangles_at(vertex), [&](std::uint32_t triangle) {
            return std::ranges::any_of(triangles_[triangle].vertices, [&](std::uint32_t corner) {
                return rim_.has(corner) && head_[rim_.number_of(corner)] == cluster;
            });
        });
    }

    const Rim &rim_;
    const std::vector<MeshTriangle> &triangles_;
    double tolerance_m_;
    std::vector<std::uint32_t> head_;
    std::vector<std::uint32_t> next_; ///< the members of a cluster, in a ring
    std::vector<std::uint32_t> size_; ///< of heads
};

} // namespace

ClosedCracks close_cracks(const std::vector<MeshTriangle> &triangles, const EdgeTable &edges,
                          const std::vector<Vector3> &vertices_m, double tolerance_m) {
    SPRINGDRIVE_ASSERT(tolerance_m > 0.0);
    ClosedCracks closed;
    closed.stands_for.resize(vertices_m.size());
    std::iota(closed.stands_for.begin(), closed.stands_for.end(), 0U);

    const Rim rim(triangles, edges, vertices_m);
    Clusters clusters(rim, triangles, tolerance_m);
    for (const NearPair &pair : near_pairs(rim.places_m(), tolerance_m)) {
        clusters.join(pair.a, pair.b);
    }
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
