// Divides anew what meets in one vertex: a fan of thousands of triangles, as of a cap or of a
// sphere's pole.
//
// Near its vertex each of them is within reach of the proxy, and a long thin triangle fills no more
// than a sliver of its box; either way a search looks at most of them. A graded fan has rings about
// its vertex, with ever fewer triangles towards it: as few as the shape of the surface allows.
// Where it is rough, they become few within a micrometre of the vertex.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/facet.h"
#include "engine/contact/mesh/mesh_report.h"
#include "engine/contact/mesh/triangle_soup.h"

#include <array>
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

/// One triangle of a fan: the edge opposite to the vertex, in winding order.
struct FanTriangle {
    std::uint32_t from = 0;
    std::uint32_t to = 0;
    std::uint32_t apex = 0; ///< which corner of the facet is at the vertex
    std::uint32_t facet = 0;
    bool is_own = false; ///< whether it is part of this vertex' fans, and of no other's
};

/// Triangles at one vertex, each next to the one before it.
struct TriangleFan {
    Vector3 apex_m{Vector3::Zero()};
    std::vector<Vector3> rim_m;        ///< one more than triangles; the first again if it is closed
    std::vector<std::uint32_t> facets; ///< of the triangles

    /// From the apex to a point of the rim [m].
    [[nodiscard]] Vector3 spoke_m(std::size_t i) const { return rim_m[i] - apex_m; }
};

/// The triangles at each vertex where at least `min_size` of them meet; the vertices with most of
/// them first. Each is the own of one vertex only.
/// @param left_out   indices of triangles, in ascending order, that have no facet
/// @param vertices   their number
[[nodiscard]] std::vector<std::vector<FanTriangle>>
find_fan_triangles(const std::vector<MeshTriangle> &triangles,
                   const std::vector<std::uint32_t> &left_out, std::size_t vertices,
                   std::size_t min_size);

/// The fans of the triangles at one vertex that are its own, of one material and the same sides
/// each. Open ones first, then those that close.
[[nodiscard]] std::vector<TriangleFan> fans_of(std::vector<FanTriangle> triangles,
                                               const std::vector<FacetSource> &facets);

/// Parts of a fan whose spokes are about as long: of a fan from a vertex of its own outline the
/// first and the last are short. On the spoke between two parts the rings of one do not meet those
/// of the other, which leaves no gap on a straight line.
[[nodiscard]] std::vector<TriangleFan> divided_by_length(const TriangleFan &fan);

/// A spoke of a ring: which of the fan's, at which fraction of its length.
struct RingPoint {
    std::size_t spoke = 0;
    double fraction = 0.0;
};

using RingTriangle = std::array<RingPoint, 3>;

/// A fan's new triangles.
struct FanRings {
    std::vector<RingTriangle> triangles; ///< empty if the fan stays as it is
    bool is_coarse = false;
};

/// The rings of a fan whose spokes are about as long.
/// @throw Cancelled if this thread's work was cancelled
[[nodiscard]] FanRings rings_of(const TriangleFan &fan);

} // namespace springdrive::contact
