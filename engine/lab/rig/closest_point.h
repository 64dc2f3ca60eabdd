// The contact of a penalty method: the point of the mesh closest to the tip, regardless of the
// tip's history. Implemented for comparison with the proxy.
#pragma once

#include "base/vector.h"
#include "engine/contact/bvh/box_tree.h"
#include "engine/contact/mesh/triangle_soup.h"

#include <array>
#include <cstddef>
#include <vector>

namespace springdrive::rig {

struct ClosestPoint {
    Vector3 point_m{Vector3::Zero()};
    Vector3 normal{Vector3::Zero()}; ///< of its triangle: unit, by its winding
};

/// A mesh without preparation. The search begins with the last closest triangle, which saves most
/// of the work for a slowly moving tip and does not change the distance found.
class ClosestPointFinder {
public:
    /// @pre there is at least one triangle, and each has an area
    explicit ClosestPointFinder(const contact::TriangleSoup &soup);

    [[nodiscard]] ClosestPoint closest(const Vector3 &to_m);

private:
    std::vector<std::array<Vector3, 3>> corners_m_; ///< in the order of the tree
    contact::BoxTree tree_;
    std::size_t last_ = 0; ///< the triangle that was closest
};

} // namespace springdrive::rig
