// Divides anew what meets in one vertex: a fan of thousands of triangles, as of a cap or of a
// sphere's pole.
//
// Near its vertex each of them is within reach of the proxy, and a long thin triangle fills no more
// than a sliver of its box; either way a search looks at most of them. A graded fan has rings about
// its vertex, with ever fewer triangles towards it: as few as the shape of the surface allows.
// Where it is rough, they become few within a micrometre of the vertex.
#pragma once

#include "engine/contact/mesh/facet.h"
#include "engine/contact/mesh/mesh_report.h"
#include "engine/contact/mesh/mesh_triangle.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace springdrive::contact {

/// As many triangles at a vertex fit into the list that the proxy keeps of its neighbourhood.
inline constexpr std::size_t kMinGradedFan = 48;

/// A graded fan is no farther than this from the given one, unless it is coarse [m]: well within
/// the clearance, so that a proxy beside the one does not cross the other.
inline constexpr double kGradingError_m = 0.3 * kClearance_m;

/// No farther than this where a fan is rough near its vertex, or would still have hundreds of
/// triangles there: a thirtieth of what a device resolves [m].
inline constexpr double kCoarseGradingError_m = 1e-6;

/// The largest fans are graded first, until they have become this many facets.
inline constexpr std::size_t kMaxGradedFacets = 1'000'000;

/// Grades the fans of at least kMinGradedFan triangles of one material and the same sides,
/// connected over their common edges, where that leads to fewer triangles at the vertex. Others
/// stay as they are, and crowded. The new facets come last, and each names one of the triangles
/// that it lies on.
/// @param facets     one for each triangle that is not left out, in order; replaced
/// @param left_out   indices of triangles, in ascending order
/// @param vertices   their number
/// @throw Cancelled if this thread's work was cancelled
GradedFans grade_fans(std::vector<FacetSource> &facets, const std::vector<MeshTriangle> &triangles,
                      const std::vector<std::uint32_t> &left_out, std::size_t vertices);

} // namespace springdrive::contact
