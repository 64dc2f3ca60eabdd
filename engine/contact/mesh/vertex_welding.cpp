#include "engine/contact/mesh/mesh_stitching.h"

#include "base/assertions.h"
#include "base/cancellation.h"
#include "engine/contact/mesh/vertex_grid.h"

#include <algorithm>

namespace springdrive::contact {

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

} // namespace springdrive::contact
