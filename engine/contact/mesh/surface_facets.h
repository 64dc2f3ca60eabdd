// The last step of mesh preparation: from triangles with a topology to facets.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/edge_table.h"
#include "engine/contact/mesh/facet.h"
#include "engine/contact/mesh/mesh_topology.h"
#include "engine/contact/mesh/mesh_triangle.h"
#include "engine/contact/mesh/triangle_soup.h"

#include <cstdint>
#include <vector>

namespace springdrive::contact {

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

} // namespace springdrive::contact
