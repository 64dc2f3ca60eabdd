// What mesh preparation found in the triangles of a file, and did to them, and the same as text for
// the user.
#pragma once

#include "engine/contact/mesh/triangle_soup.h"

#include <cstddef>
#include <string>
#include <vector>

namespace springdrive::contact {

/// Numbers of graded fans.
struct GradedFans {
    std::size_t all = 0;
    std::size_t coarse = 0; ///< farther from the given one than kGradingError_m of fan_grading.h
};

/// What was found in a soup, for messages. Edges and components are those of the prepared mesh,
/// slivers included, unless they say otherwise.
struct MeshReport {
    std::size_t triangles_given = 0;
    std::size_t triangles_kept = 0;       ///< of those given; the next three count the rest
    std::size_t degenerate_triangles = 0; ///< too thin to have a normal, or not finite
    std::size_t duplicate_triangles = 0;  ///< same three vertices, same winding, as another
    std::size_t merged_triangles = 0;     ///< the other side of another, which has two sides now
    std::size_t flipped_triangles = 0;    ///< turned to agree with their neighbours
    std::size_t split_triangles = 0;      ///< divided where vertices of others touch their edges
    std::size_t welded_vertices = 0;      ///< replaced by another at the same place
    std::size_t closed_cracks = 0;        ///< vertices moved to others across a crack
    GradedFans graded_fans;               ///< triangles at one vertex, divided anew
    double largest_move_m = 0.0;          ///< of a vertex or an edge, to close a crack
    std::size_t open_edges_given = 0;     ///< used by one triangle only, before cracks were closed
    std::size_t open_edges = 0;           ///< and after
    std::size_t non_manifold_edges = 0;   ///< used by more than two triangles
    std::size_t components = 0;           ///< connected over edges
    std::size_t closed_components = 0;    ///< bound a volume: touchable from outside only
    std::size_t inward_components = 0;    ///< closed, but wound to face inwards
    std::size_t unorientable_components = 0; ///< their triangles cannot agree which side is out
    std::vector<std::size_t> left_out_of_material; ///< degenerate and duplicate, each material's
};

/// One line for each way in which a surface differs from a closed, clean mesh, with the names of
/// the nodes it concerns; empty for a clean one.
[[nodiscard]] std::vector<std::string>
warnings_about(const MeshReport &report, const std::vector<SurfaceMaterial> &materials);

} // namespace springdrive::contact
