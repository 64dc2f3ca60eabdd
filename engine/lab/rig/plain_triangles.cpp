#include "engine/lab/rig/plain_triangles.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace springdrive::rig {

namespace {

/// Which minimise cancellation.
std::array<Vector3, 2> two_shorter_edges(const std::array<Vector3, 3> &corners_m) {
    const std::array<Vector3, 3> edges{Vector3(corners_m[1] - corners_m[0]),
                                       Vector3(corners_m[2] - corners_m[1]),
                                       Vector3(corners_m[0] - corners_m[2])};
    const auto *const longest =
        std::ranges::max_element(edges, {}, [](const Vector3 &edge) { return edge.squaredNorm(); });
    const auto i = static_cast<std::size_t>(longest - edges.begin());
    return {edges[(i + 1) % 3], edges[(i + 2) % 3]};
}

Vector3 nearest_on_edge(const Vector3 &a_m, const Vector3 &b_m, const Vector3 &point_m) {
    const Vector3 edge = b_m - a_m;
    return a_m + std::clamp((point_m - a_m).dot(edge) / edge.squaredNorm(), 0.0, 1.0) * edge;
}

} // namespace

double PlainTriangle::beyond_m(const Vector3 &point_m) const {
    double max_m = -std::numeric_limits<double>::infinity();
    double longest_m = 0.0;
    double beyond_ends_m = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        const Vector3 edge = corners_m[(i + 1) % 3] - corners_m[i];
        const Vector3 from_corner = point_m - corners_m[i];
        max_m = std::max(max_m, edge.cross(normal).normalized().dot(from_corner));
        if (const double length_m = edge.norm(); length_m > longest_m) {
            longest_m = length_m;
            const double along_m = edge.dot(from_corner) / length_m;
            beyond_ends_m = std::max(-along_m, edge.dot(from_corner - edge) / length_m);
        }
    }
    return std::max(max_m, beyond_ends_m);
}

Away PlainTriangle::away(const Vector3 &point_m) const {
    const double height = height_m(point_m);
    if (beyond_m(point_m) <= 0.0) {
        return {std::abs(height), height < 0.0 ? Vector3(-normal) : normal};
    }
    Away nearest{std::numeric_limits<double>::infinity(), normal};
    for (std::size_t i = 0; i < 3; ++i) {
        const Vector3 gap =
            point_m - nearest_on_edge(corners_m[i], corners_m[(i + 1) % 3], point_m);
        const double distance_m = gap.norm();
        if (distance_m < nearest.distance_m) {
            nearest = {distance_m, distance_m > 0.0 ? Vector3(gap / distance_m) : normal};
        }
    }
    return nearest;
}

Eigen::AlignedBox3d PlainTriangle::bounds() const {
    Eigen::AlignedBox3d box(corners_m[0]);
    return box.extend(corners_m[1]).extend(corners_m[2]);
}

double PlainTriangle::sine() const {
    const auto [a, b] = two_shorter_edges(corners_m);
    return a.cross(b).norm() / (a.norm() * b.norm());
}

std::vector<PlainTriangle> plain_triangles(const std::vector<contact::FacetSource> &facets) {
    std::vector<PlainTriangle> triangles;
    triangles.reserve(facets.size());
    for (const contact::FacetSource &facet : facets) {
        const auto [a, b] = two_shorter_edges(facet.corners_m);
        triangles.push_back(
            {facet.corners_m, a.cross(b).normalized(), facet.sides == contact::FacetSides::two});
    }
    return triangles;
}

} // namespace springdrive::rig
