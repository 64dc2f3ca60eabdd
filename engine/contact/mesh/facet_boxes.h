// The boxes by which a search finds facets.
//
// The box of a long thin facet that lies obliquely, or of one of many at a vertex, holds little of
// it and much of its neighbours: near such facets a search would look at hundreds. Those are cut
// into pieces, each with a box of its own. The facets themselves stay whole.
#pragma once

#include "engine/contact/mesh/facet.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace springdrive::contact {

struct FacetBoxes {
    std::vector<Eigen::AlignedBox3d> boxes_m;
    std::vector<std::uint32_t> facet_of_box;
};

/// At most this many boxes more than facets: they take 32 bytes and some microseconds each.
inline constexpr std::size_t kMaxMoreBoxes = 500'000;

/// At least one box for each facet; the boxes of a facet cover it.
[[nodiscard]] FacetBoxes boxes_of(const std::vector<FacetSource> &facets);

} // namespace springdrive::contact
