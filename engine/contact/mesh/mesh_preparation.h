// Turns the triangles of a file into touchable ones: welded, cracks closed, without degenerate and
// repeated triangles, consistently wound, each classified as bounding a volume or as a sheet.
// Reports what it found and did.
#pragma once

#include "base/parallel.h"
#include "engine/contact/mesh/facet.h"
#include "engine/contact/mesh/fan_grading.h"
#include "engine/contact/mesh/triangle_soup.h"

#include <cstddef>
#include <vector>

namespace springdrive::contact {

/// Cracks up to this width are closed [m]: the single-precision rounding of coordinates of tens of
/// metres, and far below what a hand perceives.
inline constexpr double kCrackTolerance_m = 5e-6;

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

struct PreparedMesh {
    std::vector<FacetSource> facets;
    MeshReport report;
};

/// @param threads the maximum number used; the facets are the same for any number
/// @throw std::invalid_argument if an index of the soup is out of range or it lacks materials: a
///        mistake of the program, since readers of files check this first.
/// @throw InputError if that needs more steps than a PreparationAllowance has.
/// @throw std::length_error if there are more than kMaxTriangles.
[[nodiscard]] PreparedMesh prepare_mesh(const TriangleSoup &soup,
                                        unsigned threads = all_processors());

} // namespace springdrive::contact
