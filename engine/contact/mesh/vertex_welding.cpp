#include "engine/contact/mesh/vertex_welding.h"

#include "base/assertions.h"
#include "base/parallel.h"
#include "base/wanted.h"
#include "engine/contact/mesh/vertex_grid.h"

#include <algorithm>
#include <cstddef>

namespace springdrive::contact {

namespace {

/// Cell size in tolerances: large enough that a vertex rarely lies near the wall of its cell and
/// needs its neighbours searched, small enough that a cell holds few vertices.
constexpr double kCellTolerances = 16.0;

/// Buckets are scattered in memory: prefetched this many vertices ahead, they arrive in time.
constexpr std::uint32_t kAhead = 16;

} // namespace

std::vector<std::uint32_t> weld_vertices(const std::vector<Vector3> &vertices_m, double tolerance_m,
                                         unsigned threads) {
    SPRINGDRIVE_ASSERT(tolerance_m > 0.0 && threads > 0);
    const auto count = static_cast<std::uint32_t>(vertices_m.size());
    VertexGrid grid(vertices_m, tolerance_m, kCellTolerances * tolerance_m);
    std::vector<VertexGrid::Home> homes(count);
    in_chunks(count, threads, [&](unsigned, std::size_t first, std::size_t last) {
        for (std::size_t vertex = first; vertex < last; ++vertex) {
            stop_if_given_up(vertex);
            homes[vertex] = grid.home_of(static_cast<std::uint32_t>(vertex));
        }
    });

    std::vector<std::uint32_t> stands_for(count);
    for (std::uint32_t vertex = 0; vertex < count; ++vertex) {
        stop_if_given_up(vertex);
        grid.prefetch(homes[std::min(vertex + kAhead, count - 1)]);
        stands_for[vertex] = vertex;
        const auto take_its_place = [&](std::uint32_t earlier) {
            stands_for[vertex] = earlier;
            return true;
        };
        if (vertices_m[vertex].allFinite() &&
            !grid.visit_near(vertex, homes[vertex], take_its_place)) {
            grid.insert(vertex, homes[vertex]);
        }
    }
    return stands_for;
}

} // namespace springdrive::contact
