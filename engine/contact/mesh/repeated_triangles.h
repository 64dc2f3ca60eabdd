// Triangles that are given more than once.
#pragma once

#include "engine/contact/mesh/edge_table.h"
#include "engine/contact/mesh/mesh_triangle.h"

#include <cstdint>
#include <vector>

namespace springdrive::contact {

/// What was dropped, by index in the soup.
struct RepeatedTriangles {
    std::vector<std::uint32_t> same_winding; ///< another of their vertices and winding stays
    std::vector<std::uint32_t> merged;       ///< another of their vertices stands for both windings
};

/// Drops triangles that have their three vertices in common with an earlier one, and keeps the
/// order of the others. Of equal windings one is enough. A triangle and its other side become one
/// that has both windings and is touched from both sides: nothing can be fallen through, whether
/// they were a sheet, the wall between two solids, or part of a body given twice to be seen from
/// within too. Where both sides are of different materials they are left as they are, one-sided
/// each, which feels the same but for the material.
/// @param edges those of `triangles`; no longer true if anything was dropped
/// @param material_of_triangle by index in the soup
[[nodiscard]] RepeatedTriangles
drop_repeated_triangles(std::vector<MeshTriangle> &triangles, const EdgeTable &edges,
                        const std::vector<std::uint16_t> &material_of_triangle, unsigned threads);

} // namespace springdrive::contact
