// Turns the triangles of a file into triangles fit to be touched: welded, without the degenerate
// and the repeated, each known to bound a volume or to be a sheet. Says what it found.
#pragma once

#include "engine/contact/facet.h"
#include "engine/contact/triangle_soup.h"

#include <cstddef>
#include <vector>

namespace springdrive {

/// What was found in a soup, for messages. Edges and components are those of the welded mesh,
/// without collapsed and repeated triangles.
struct MeshReport {
    std::size_t triangles_given = 0;
    std::size_t triangles_kept = 0;
    std::size_t degenerate_triangles = 0; ///< too thin to have a normal, or not finite
    std::size_t duplicate_triangles = 0;  ///< same three vertices, same winding, as another
    std::size_t welded_vertices = 0;      ///< replaced by another at the same place
    std::size_t open_edges = 0;           ///< used by one triangle only
    std::size_t non_manifold_edges = 0;   ///< used by more than two triangles
    std::size_t components = 0;           ///< connected over edges
    std::size_t closed_components = 0;    ///< bound a volume: touchable from outside only
    std::size_t inward_components = 0;    ///< closed, but wound to face inwards
    std::vector<std::size_t> left_out_of_material; ///< degenerate and duplicate, each material's
};

struct PreparedMesh {
    std::vector<FacetSource> facets;
    MeshReport report;
};

/// @throw std::invalid_argument if an index of the soup is out of range or it lacks materials:
///        a mistake of the program, since whoever reads a file checks it first.
[[nodiscard]] PreparedMesh prepare_mesh(const TriangleSoup &soup);

} // namespace springdrive
