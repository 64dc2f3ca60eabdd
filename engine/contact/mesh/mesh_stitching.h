// Joins what was meant to be one, but differs by rounding, computation or conversion. In this
// order:
//
//   - vertices at the same place: exporters repeat a vertex for every normal and texture coordinate
//     it carries, and only positions matter to contact (vertex_welding.cpp)
//   - vertices along open edges across a narrow crack (boundary_stitching.cpp)
//   - T-junctions, where one triangle's side runs along several sides of others, whose vertices lie
//     on it only up to round-off (t_junction_removal.cpp)
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/edge_table.h"
#include "engine/contact/mesh/mesh_triangle.h"
#include "engine/contact/mesh/preparation_allowance.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace springdrive::contact {

/// For each vertex the index of its representative: itself, or an earlier vertex within
/// `tolerance_m` that represents itself. So no vertex moves by more than the tolerance, however
/// long a chain of near neighbours is. Vertices that are not finite represent themselves.
/// @pre tolerance_m > 0, threads > 0
/// @throw InputError where it needs more steps than allowed
[[nodiscard]] std::vector<std::uint32_t> weld_vertices(const std::vector<Vector3> &vertices_m,
                                                       double tolerance_m,
                                                       PreparationAllowance &allowance,
                                                       unsigned threads = 1);

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

struct SplitEdges {
    std::size_t split_triangles = 0;
    double largest_move_m = 0.0; ///< of a point of an edge
};

/// Routes open edges through the ends of other open edges that lie within the tolerance of their
/// interiors, and divides their triangles accordingly. The pieces are appended to `triangles`,
/// except one that replaces the whole, and keep its index in the soup.
/// @param edges those of `triangles`; no longer valid if anything was split
/// @param threads the maximum number used; the result is the same for any number
/// @pre tolerance_m > 0, threads > 0
/// @throw InputError where it needs more steps than allowed; nothing was divided then
[[nodiscard]] SplitEdges split_edges(std::vector<MeshTriangle> &triangles, const EdgeTable &edges,
                                     const std::vector<Vector3> &vertices_m, double tolerance_m,
                                     PreparationAllowance &allowance, unsigned threads);

} // namespace springdrive::contact
