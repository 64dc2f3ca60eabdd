#include "engine/lab/rig/closest_point.h"

#include "base/assertions.h"
#include "base/parallel.h"
#include "engine/contact/mesh/facet.h"

#include <Eigen/Geometry>

#include <cmath>
#include <cstdint>
#include <limits>

namespace springdrive::rig {

ClosestPointFinder::ClosestPointFinder(const contact::TriangleSoup &soup) {
    SPRINGDRIVE_ASSERT(!soup.triangles.empty());
    std::vector<Eigen::AlignedBox3d> boxes;
    boxes.reserve(soup.triangles.size());
    for (const auto &triangle : soup.triangles) {
        Eigen::AlignedBox3d box;
        for (const std::uint32_t corner : triangle) {
            box.extend(soup.vertices_m[corner]);
        }
        boxes.push_back(box);
    }
    tree_ = contact::BoxTree(boxes, all_processors());
    corners_m_.reserve(soup.triangles.size());
    for (const std::uint32_t item : tree_.take_order()) {
        const auto &[a, b, c] = soup.triangles[item];
        corners_m_.push_back({soup.vertices_m[a], soup.vertices_m[b], soup.vertices_m[c]});
        SPRINGDRIVE_ASSERT_AUDIT(contact::min_height_m(corners_m_.back()) > 0.0);
    }
}

ClosestPoint ClosestPointFinder::closest(const Vector3 &to_m) {
    contact::SearchBudget unlimited{std::numeric_limits<int>::max()};
    ClosestPoint closest;
    closest.point_m = contact::nearest_on_triangle(corners_m_[last_], to_m).point_m;
    const double last_m2 = (closest.point_m - to_m).squaredNorm();
    double min_m2 = last_m2;
    tree_.within(to_m, std::sqrt(last_m2), unlimited, [&](std::uint32_t item, double) {
        const Vector3 point_m = contact::nearest_on_triangle(corners_m_[item], to_m).point_m;
        const double distance_m2 = (point_m - to_m).squaredNorm();
        if (distance_m2 < min_m2) {
            min_m2 = distance_m2;
            last_ = item;
            closest.point_m = point_m;
        }
        return min_m2;
    });
    const auto &[a, b, c] = corners_m_[last_];
    closest.normal = (b - a).cross(c - a).normalized();
    return closest;
}

} // namespace springdrive::rig
