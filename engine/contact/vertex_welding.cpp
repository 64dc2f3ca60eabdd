#include "engine/contact/vertex_welding.h"

#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>

namespace springdrive {

namespace {

/// Cell size in tolerances: large enough that a vertex rarely lies near the wall of its cell and
/// needs its neighbours searched, small enough that a cell holds few vertices.
constexpr double kCellTolerances = 16.0;

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// Integer coordinates of a cell, kept as doubles: these cannot overflow.
using Cell = Vector3;

[[nodiscard]] std::size_t hash(const Cell &cell) {
    std::uint64_t mixed = 0;
    for (const double coordinate : cell) {
        // Adding zero turns -0 into +0, which are equal and so must hash alike.
        mixed = (mixed ^ std::bit_cast<std::uint64_t>(coordinate + 0.0)) * 0x9E3779B97F4A7C15U;
        mixed ^= mixed >> 32;
    }
    return mixed;
}

/// Chained hash table from cells to the welded vertices in them. It stores no cells: a chain may
/// mix several, and the distance decides.
class VertexGrid {
public:
    VertexGrid(const std::vector<Vector3> &vertices_m, double tolerance_m)
        : vertices_m_(vertices_m), tolerance_m_(tolerance_m),
          cell_m_(kCellTolerances * tolerance_m),
          first_in_bucket_(std::bit_ceil(vertices_m.size() + 1), kNone),
          next_in_bucket_(vertices_m.size(), kNone) {}

    void insert(std::uint32_t vertex) {
        std::uint32_t &first = bucket((vertices_m_[vertex] / cell_m_).array().floor());
        next_in_bucket_[vertex] = first;
        first = vertex;
    }

    /// An inserted vertex within the tolerance of `vertex`, or kNone.
    [[nodiscard]] std::uint32_t find_near(std::uint32_t vertex) {
        const Vector3 reach = Vector3::Constant(tolerance_m_);
        const Cell lower = ((vertices_m_[vertex] - reach) / cell_m_).array().floor();
        const Cell upper = ((vertices_m_[vertex] + reach) / cell_m_).array().floor();
        for (int corner = 0; corner < 8; ++corner) {
            Cell cell = lower;
            bool is_repeated = false;
            for (int axis = 0; axis < 3; ++axis) {
                if ((corner & (1 << axis)) != 0) {
                    cell[axis] = upper[axis];
                    is_repeated = is_repeated || upper[axis] == lower[axis];
                }
            }
            const std::uint32_t found = is_repeated ? kNone : find_near_in(cell, vertex);
            if (found != kNone) {
                return found;
            }
        }
        return kNone;
    }

private:
    [[nodiscard]] std::uint32_t &bucket(const Cell &cell) {
        return first_in_bucket_[hash(cell) & (first_in_bucket_.size() - 1)];
    }

    [[nodiscard]] std::uint32_t find_near_in(const Cell &cell, std::uint32_t vertex) {
        std::uint32_t candidate = bucket(cell);
        while (candidate != kNone && (vertices_m_[candidate] - vertices_m_[vertex]).squaredNorm() >
                                         tolerance_m_ * tolerance_m_) {
            candidate = next_in_bucket_[candidate];
        }
        return candidate;
    }

    const std::vector<Vector3> &vertices_m_;
    double tolerance_m_;
    double cell_m_;
    std::vector<std::uint32_t> first_in_bucket_;
    std::vector<std::uint32_t> next_in_bucket_;
};

} // namespace

std::vector<std::uint32_t> weld_vertices(const std::vector<Vector3> &vertices_m,
                                         double tolerance_m) {
    VertexGrid grid(vertices_m, tolerance_m);
    std::vector<std::uint32_t> stands_for(vertices_m.size());
    for (std::uint32_t vertex = 0; vertex < stands_for.size(); ++vertex) {
        const std::uint32_t earlier =
            vertices_m[vertex].allFinite() ? grid.find_near(vertex) : vertex;
        stands_for[vertex] = earlier == kNone ? vertex : earlier;
        if (earlier == kNone) {
            grid.insert(vertex);
        }
    }
    return stands_for;
}

} // namespace springdrive
