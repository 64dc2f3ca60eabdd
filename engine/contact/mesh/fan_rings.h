// Divides one fan into rings about its vertex, with ever fewer triangles towards it.
#pragma once

#include "engine/contact/mesh/triangle_fans.h"

#include <array>
#include <cstddef>
#include <vector>

namespace springdrive::contact {

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
