#include "engine/lab/model_selection/simplified_surface.h"

#include "base/assertions.h"
#include "base/cancellation.h"

#include <meshoptimizer.h>

#include <array>
#include <map>
#include <vector>

namespace springdrive::model_selection {

namespace {

using Point = std::array<float, 3>;

/// Vertices in single precision, merged where they coincide: a mesh whose faces have their own
/// vertices, for sharp normals, would otherwise come apart.
struct WeldedVertices {
    std::vector<Point> places;
    std::vector<Vector3> exact_m; ///< of each place, in double precision
    std::vector<unsigned> place_of_vertex;

    explicit WeldedVertices(const contact::TriangleSoup &soup) {
        std::map<Point, unsigned> known;
        for (const Vector3 &vertex_m : soup.vertices_m) {
            stop_if_given_up(place_of_vertex.size());
            const Point point = {static_cast<float>(vertex_m.x()), static_cast<float>(vertex_m.y()),
                                 static_cast<float>(vertex_m.z())};
            const auto [entry, is_new] =
                known.try_emplace(point, static_cast<unsigned>(places.size()));
            if (is_new) {
                places.push_back(point);
                exact_m.push_back(vertex_m);
            }
            place_of_vertex.push_back(entry->second);
        }
    }
};

std::vector<unsigned> fewer(const std::vector<unsigned> &indices, const WeldedVertices &vertices,
                            int divisor) {
    // Relative to the extent: unlimited, as the error is measured by touch.
    constexpr float kAnyError = 1.0F;
    const std::size_t target = indices.size() / 3 / static_cast<std::size_t>(divisor) * 3;
    std::vector<unsigned> left(indices.size());
    left.resize(meshopt_simplify(left.data(), indices.data(), indices.size(),
                                 vertices.places.front().data(), vertices.places.size(),
                                 sizeof(Point), target, kAnyError, 0, nullptr));
    return left;
}

} // namespace

contact::TriangleSoup simplified(const contact::TriangleSoup &soup, int divisor) {
    SPRINGDRIVE_ASSERT(divisor >= 1);
    const WeldedVertices vertices(soup);
    std::vector<std::vector<unsigned>> corners_of_material(soup.materials.size());
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        for (const std::uint32_t corner : soup.triangles[i]) {
            corners_of_material[soup.material_of_triangle[i]].push_back(
                vertices.place_of_vertex[corner]);
        }
    }
    contact::TriangleSoup result;
    result.vertices_m = vertices.exact_m;
    result.materials = soup.materials;
    for (std::size_t material = 0; material < corners_of_material.size(); ++material) {
        if (corners_of_material[material].empty()) {
            continue;
        }
        const std::vector<unsigned> left = fewer(corners_of_material[material], vertices, divisor);
        for (std::size_t i = 0; i < left.size(); i += 3) {
            result.triangles.push_back({left[i], left[i + 1], left[i + 2]});
            result.material_of_triangle.push_back(static_cast<std::uint16_t>(material));
        }
    }
    return result;
}

} // namespace springdrive::model_selection
