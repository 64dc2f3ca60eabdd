// Queries of the same surfaces by Embree and FCL, where those are installed: the cost of a query
// that is part of the proxy's work, and its accuracy.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/triangle_soup.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace springdrive::bench {

/// The times and results of the queries.
struct Answers {
    std::vector<double> floor_ns; ///< its minimum of `kRepeats`, as for the proxy's updates
    std::vector<double> distances_m;
};

struct EmbreeTimes {
    /// Of a segment of 2 mm from the tip away from the origin.
    std::vector<double> cast_floor_ns;
    /// How far a hit lay from where the segment meets the plane of that triangle, at most [m].
    double cast_error_m = 0.0;
    /// Of the surface's point nearest to the tip, searched for at any distance.
    Answers closest;
};

/// Embree 3, robust, one thread; the first `closest_queries` tips only for the closest point.
/// Nothing where it is not built in.
[[nodiscard]] std::optional<EmbreeTimes> time_embree(const contact::TriangleSoup &soup,
                                                     const std::vector<Vector3> &tips_m,
                                                     std::size_t closest_queries);

/// `fcl::distance` of a ball of 0.1 mm about the first `queries` tips to a BVHModel<OBBRSSd>, the
/// ball's radius added again. Nothing where it is not built in.
[[nodiscard]] std::optional<Answers> time_fcl(const contact::TriangleSoup &soup,
                                              const std::vector<Vector3> &tips_m,
                                              std::size_t queries);

} // namespace springdrive::bench
