// Finds the triangles near a point. It shares no code with the search that the proxy uses, so that
// checks of the proxy stay independent of it.
#pragma once

#include "base/vector.h"
#include "engine/lab/rig/plain_triangles.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace springdrive::rig {

/// A binary tree of boxes, halved at the median of the triangles' middles.
class NearbyTriangles {
public:
    /// @param triangles  must outlive this
    explicit NearbyTriangles(std::span<const PlainTriangle> triangles);

    /// The triangles whose boxes are no farther than `radius_m` from a point, by ascending index.
    [[nodiscard]] std::vector<std::size_t> within(const Vector3 &centre_m, double radius_m) const;

private:
    struct Node {
        Eigen::AlignedBox3d box;
        std::uint32_t first = 0; ///< of its triangles in `order_`
        std::uint32_t last = 0;  ///< one beyond
        std::uint32_t other = 0; ///< its second half; the first follows it. 0: not halved
    };

    std::uint32_t add(std::uint32_t first, std::uint32_t last,
                      const std::vector<Vector3> &middles_m);

    std::span<const PlainTriangle> triangles_;
    std::vector<std::uint32_t> order_; ///< indices of triangles
    std::vector<Node> nodes_;
};

} // namespace springdrive::rig
