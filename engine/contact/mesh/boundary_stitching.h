// Closes narrow cracks: vertices along open edges that were meant to coincide, but differ by
// rounding, computation or conversion.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/edge_table.h"
#include "engine/contact/mesh/mesh_triangle.h"
#include "engine/contact/mesh/preparation_allowance.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace springdrive::contact {

struct ClosedCracks {
    std::vector<std::uint32_t> stands_for; ///< for each vertex the one that replaces it
    std::size_t moved_vertices = 0;
    double largest_move_m = 0.0;
};

/// Welds ends of open edges that lie within the tolerance of each other, the nearest first. No
/// vertex moves by more than the tolerance. Two corners of one triangle are never welded, neither
/// directly nor through others: however fine a mesh, no triangle collapses.
/// @param edges those of `triangles`
/// @param threads the maximum number used; the result is the same for any number
/// @pre tolerance_m > 0, threads > 0
/// @throw InputError where it needs more steps than allowed
[[nodiscard]] ClosedCracks close_cracks(const std::vector<MeshTriangle> &triangles,
                                        const EdgeTable &edges,
                                        const std::vector<Vector3> &vertices_m, double tolerance_m,
                                        PreparationAllowance &allowance, unsigned threads);

} // namespace springdrive::contact
