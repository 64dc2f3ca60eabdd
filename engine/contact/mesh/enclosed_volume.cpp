#include "engine/contact/mesh/enclosed_volume.h"

#include <Eigen/Geometry>

#include <cstddef>

namespace springdrive::contact {

std::vector<double> enclosed_volumes_m3(const std::vector<MeshTriangle> &triangles,
                                        const MeshTopology &topology,
                                        const std::vector<Vector3> &vertices_m) {
    std::vector<double> volumes(topology.components.size(), 0.0);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const std::uint32_t number = topology.component_of_triangle[i];
        const MeshComponent &component = topology.components[number];
        if (!component.is_closed ||
            (component.has_sheets_apart && triangles[i].has_both_windings)) {
            continue;
        }
        // From the tetrahedra to a point near the mesh.
        const Vector3 &origin = vertices_m[triangles.front().vertices[0]];
        const auto &[a, b, c] = triangles[i].vertices;
        volumes[number] +=
            (vertices_m[a] - origin).dot((vertices_m[b] - origin).cross(vertices_m[c] - origin)) /
            6.0;
    }
    return volumes;
}

} // namespace springdrive::contact
