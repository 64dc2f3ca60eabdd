// Turns the triangles of a file into touchable ones: welded, cracks closed, without degenerate and
// repeated triangles, consistently wound, each classified as bounding a volume or as a sheet.
// Reports what it found and did.
#pragma once

#include "base/parallel.h"
#include "base/vector.h"
#include "engine/contact/mesh/facet.h"
#include "engine/contact/mesh/mesh_report.h"
#include "engine/contact/mesh/mesh_topology.h"
#include "engine/contact/mesh/triangle_soup.h"

#include <cstdint>
#include <vector>

namespace springdrive::contact {

// The last step: from triangles with a topology to facets.

/// Triangles lower than this are slivers [m]. Their normals are unreliable.
inline constexpr double kMinHeight_m = kClearance_m;

/// Triangles lower than this have no usable normal [m]: they may consist of round-off.
inline constexpr double kMinNormalHeight_m = 1e-9;

/// Slivers to leave out, by index, in order.
///
/// The proxy cannot fall through where one was: it is nowhere wider than kMinHeight_m, its
/// neighbours over all edges stay, and the proxy keeps kClearance_m from them, twice of which
/// bridges it. Therefore one in two of adjacent slivers stays, unless it has no normal; twenty of
/// that kind would have to lie side by side to leave a gap.
/// @param edges those of `triangles`
[[nodiscard]] std::vector<std::uint32_t>
slivers_to_leave_out(const std::vector<MeshTriangle> &triangles, const EdgeTable &edges,
                     const std::vector<Vector3> &vertices_m, unsigned threads);

/// One facet for each triangle that is not left out, in order. One-sided if its component is closed
/// and its material does not say otherwise. A triangle given in both windings has two sides
/// whatever its material says, since it has normals to both.
/// @param left_out in ascending order
[[nodiscard]] std::vector<FacetSource> make_facets(const std::vector<MeshTriangle> &triangles,
                                                   const std::vector<std::uint32_t> &left_out,
                                                   const MeshTopology &topology,
                                                   const TriangleSoup &soup, unsigned threads);

/// Cracks up to this width are closed [m]: the single-precision rounding of coordinates of tens of
/// metres, and far below what a hand perceives.
inline constexpr double kCrackTolerance_m = 5e-6;

/// Nothing can be touched at a coordinate beyond this [m]. No device reaches there, and round-off
/// would exceed what the proxy counts on.
inline constexpr double kFarthest_m = 1e3;

struct PreparedMesh {
    std::vector<FacetSource> facets;
    MeshReport report;
};

/// @param threads the maximum number used; the facets are the same for any number
/// @throw std::invalid_argument if an index of the soup is out of range or it lacks materials: a
///        mistake of the program, since readers of files check this first.
/// @throw InputError if that needs more steps than a PreparationAllowance has, or a vertex has a
///        finite coordinate of kFarthest_m or more.
/// @throw std::length_error if there are more than kMaxTriangles.
[[nodiscard]] PreparedMesh prepare_mesh(const TriangleSoup &soup,
                                        unsigned threads = all_processors());

} // namespace springdrive::contact
