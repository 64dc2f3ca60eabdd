// What a penalty method touches: the point of the mesh that is closest to the tip, whatever way the
// tip came. The oldest of the methods, here to be compared with the proxy.
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

/// A mesh as it is. The search begins with the triangle that was closest last time, which spares
/// most of the work where a tip moves on slowly, and changes nothing of the answer's distance.
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
