// Turns the triangles of a file into touchable ones: welded, cracks closed, without degenerate and
// repeated triangles, consistently wound, each classified as bounding a volume or as a sheet.
// Reports what it found and did.
#pragma once

#include "base/parallel.h"
#include "engine/contact/mesh/facet.h"
#include "engine/contact/mesh/mesh_report.h"
#include "engine/contact/mesh/triangle_soup.h"

#include <vector>

namespace springdrive::contact {

/// Cracks up to this width are closed [m]: the single-precision rounding of coordinates of tens of
/// metres, and far below what a hand perceives.
inline constexpr double kCrackTolerance_m = 5e-6;

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
