#include "engine/contact/mesh/mesh_topology.h"

#include "engine/contact/mesh/triangle_sets.h"

#include <Eigen/Geometry>

namespace springdrive::contact {

namespace {

/// How often an edge is traversed: forwards minus backwards.
struct EdgeBalance {
    int all = 0;
    int of_one_winding = 0; ///< of the triangles of one winding only
};

[[nodiscard]] EdgeBalance balance_of(const Edge &edge, const std::vector<MeshTriangle> &triangles) {
    EdgeBalance balance;
    for (const EdgeUse &use : edge.uses) {
        const int direction = use.is_forward() ? 1 : -1;
        balance.all += direction;
        balance.of_one_winding += triangles[use.triangle()].has_both_windings ? 0 : direction;
    }
    return balance;
}

/// Numbers the sets by their first triangles. Returns how many there are.
std::uint32_t number_components(TriangleSets &sets, std::vector<std::uint32_t> &component) {
    std::uint32_t count = 0;
    for (std::uint32_t triangle = 0; triangle < component.size(); ++triangle) {
        const std::uint32_t root = sets.root_of(triangle);
        component[triangle] = root == triangle ? count++ : component[root];
    }
    return count;
}

} // namespace

MeshTopology find_topology(const std::vector<MeshTriangle> &triangles, const EdgeTable &edges) {
    MeshTopology topology;
    TriangleSets sets(triangles.size());
    edges.for_each([&](const Edge &edge) {
        topology.open_edges += edge.is_open() ? 1 : 0;
        topology.non_manifold_edges += edge.uses.size() > 2 ? 1 : 0;
        for (const EdgeUse &use : edge.uses.subspan(1)) {
            sets.unite(edge.uses.front().triangle(), use.triangle(), false);
        }
    });
    topology.component_of_triangle.resize(triangles.size());
    const std::uint32_t count = number_components(sets, topology.component_of_triangle);

    std::vector<bool> is_shut_by_all(count, true);
    std::vector<bool> is_shut_by_one_winding(count, false);
    bool has_both_windings = false;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        has_both_windings = has_both_windings || triangles[i].has_both_windings;
        if (!triangles[i].has_both_windings) {
            is_shut_by_one_winding[topology.component_of_triangle[i]] = true;
        }
    }
    topology.components.resize(count);
    edges.for_each([&](const Edge &edge) {
        const bool is_turned = edge.is_run_twice_the_same_way();
        if (edge.is_manifold() && !is_turned && !has_both_windings) {
            return; // nearly all edges of nearly all meshes
        }
        const EdgeBalance balance = balance_of(edge, triangles);
        const std::uint32_t number = topology.component_of_triangle[edge.uses.front().triangle()];
        if (balance.all != 0) {
            is_shut_by_all[number] = false;
        }
        if (balance.of_one_winding != 0) {
            is_shut_by_one_winding[number] = false;
        }
        if (is_turned) {
            topology.components[number].is_orientable = false;
        }
    });
    for (std::size_t i = 0; i < count; ++i) {
        topology.components[i].is_closed = is_shut_by_all[i] || is_shut_by_one_winding[i];
        topology.components[i].has_sheets_apart = is_shut_by_one_winding[i];
    }
    return topology;
}

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
