// Covers engine/contact/mesh/mesh_topology.cpp.
#include "engine/contact/mesh/mesh_topology.h"

#include "tests/engine/contact/mesh/meshes.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace springdrive::contact {
namespace {

MeshTopology topology_of(const std::vector<VertexTriple> &triples) {
    const std::vector<MeshTriangle> triangles = testing::mesh_of(triples);
    return find_topology(triangles, testing::edges_of(triangles));
}

std::vector<bool> closed(const MeshTopology &topology) {
    std::vector<bool> result;
    for (const MeshComponent &component : topology.components) {
        result.push_back(component.is_closed);
    }
    return result;
}

const std::vector<VertexTriple> kTetrahedron = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

TEST(MeshTopology, IsEmptyWithoutTriangles) {
    const MeshTopology topology = topology_of({});
    EXPECT_TRUE(topology.components.empty());
    EXPECT_EQ(topology.open_edges, 0U);
}

TEST(MeshTopology, FindsATetrahedronClosed) {
    const MeshTopology topology = topology_of(kTetrahedron);
    EXPECT_EQ(closed(topology), std::vector<bool>{true});
    EXPECT_EQ(topology.open_edges, 0U);
    EXPECT_EQ(topology.non_manifold_edges, 0U);
}

TEST(MeshTopology, FindsATetrahedronWithoutOneFaceOpen) {
    std::vector<VertexTriple> triangles = kTetrahedron;
    triangles.pop_back();
    const MeshTopology topology = topology_of(triangles);
    EXPECT_EQ(closed(topology), std::vector<bool>{false});
    EXPECT_EQ(topology.open_edges, 3U);
}

TEST(MeshTopology, DoesNotCountATetrahedronWithATurnedFaceAsClosed) {
    std::vector<VertexTriple> triangles = kTetrahedron;
    std::swap(triangles[2][0], triangles[2][1]);
    const MeshTopology topology = topology_of(triangles);
    EXPECT_EQ(closed(topology), std::vector<bool>{false});
    EXPECT_EQ(topology.open_edges, 0U);
}

TEST(MeshTopology, KeepsSolidsThatShareAnEdgeClosed) {
    std::vector<VertexTriple> triangles = kTetrahedron;
    // Another tetrahedron, on the edge 0-1 of the first.
    triangles.insert(triangles.end(), {{0, 4, 1}, {0, 1, 5}, {1, 4, 5}, {4, 0, 5}});
    const MeshTopology topology = topology_of(triangles);
    EXPECT_EQ(closed(topology), std::vector<bool>{true});
    EXPECT_EQ(topology.non_manifold_edges, 1U);
}

TEST(MeshTopology, DoesNotConnectOverAVertex) {
    std::vector<VertexTriple> triangles = kTetrahedron;
    triangles.insert(triangles.end(), {{0, 5, 4}, {0, 4, 6}, {4, 5, 6}}); // and open
    const MeshTopology topology = topology_of(triangles);
    EXPECT_EQ(closed(topology), (std::vector<bool>{true, false}));
    EXPECT_EQ(topology.component_of_triangle, (std::vector<std::uint32_t>{0, 0, 0, 0, 1, 1, 1}));
}

TEST(MeshTopology, ConnectsALongStripInAnyOrder) {
    std::vector<VertexTriple> strip;
    for (std::uint32_t i = 0; i < 5000; ++i) {
        strip.push_back(i % 2 == 0 ? VertexTriple{i, i + 1, i + 2} : VertexTriple{i + 1, i, i + 2});
    }
    std::mt19937_64 random(1);
    std::ranges::shuffle(strip, random);
    const MeshTopology topology = topology_of(strip);
    EXPECT_EQ(closed(topology), std::vector<bool>{false});
    EXPECT_EQ(topology.open_edges, 5002U); // Euler: a disc of n triangles has n + 2 border edges
}

TEST(MeshTopology, FindsASphereClosed) {
    const MeshTopology topology = topology_of(testing::icosphere(4, 1.0).triangles);
    EXPECT_EQ(closed(topology), std::vector<bool>{true});
    EXPECT_EQ(topology.open_edges, 0U);
}

TEST(MeshTopology, DetectsWhatCannotBeOriented) {
    EXPECT_FALSE(topology_of(testing::twisted_strip(9, 1)).components.front().is_orientable);
    EXPECT_TRUE(topology_of(testing::twisted_strip(9, 2)).components.front().is_orientable);
}

TEST(MeshTopology, DoesNotCountASheetOnASolid) {
    std::vector<MeshTriangle> triangles = testing::mesh_of(kTetrahedron);
    triangles.push_back({{0, 1, 4}, 4, true});
    const MeshTopology topology = find_topology(triangles, testing::edges_of(triangles));
    EXPECT_EQ(closed(topology), std::vector<bool>{true});
    EXPECT_TRUE(topology.components.front().has_sheets_apart);
    triangles.back().has_both_windings = false;
    EXPECT_EQ(closed(find_topology(triangles, testing::edges_of(triangles))),
              std::vector<bool>{false});
}

TEST(MeshTopology, CountsAFaceOfBothWindingsThatClosesASolid) {
    std::vector<MeshTriangle> triangles = testing::mesh_of(kTetrahedron);
    triangles[2].has_both_windings = true;
    const MeshTopology topology = find_topology(triangles, testing::edges_of(triangles));
    EXPECT_EQ(closed(topology), std::vector<bool>{true});
    EXPECT_FALSE(topology.components.front().has_sheets_apart);
}

TEST(MeshTopology, KeepsSolidsWithAWallBetweenThemClosed) {
    // Two tetrahedra on the face 1-2-3, which both have.
    std::vector<MeshTriangle> triangles =
        testing::mesh_of({{0, 2, 1}, {0, 1, 3}, {2, 0, 3}, {4, 1, 2}, {4, 3, 1}, {4, 2, 3}});
    triangles.push_back({{1, 2, 3}, 6, true});
    const MeshTopology topology = find_topology(triangles, testing::edges_of(triangles));
    EXPECT_EQ(closed(topology), std::vector<bool>{true});
    EXPECT_EQ(topology.non_manifold_edges, 3U);
    EXPECT_EQ(topology.open_edges, 0U);
}

TEST(MeshTopology, FindsASheetOfBothWindingsOpen) {
    std::vector<MeshTriangle> triangles = testing::mesh_of({{0, 1, 2}, {0, 2, 3}});
    triangles[0].has_both_windings = true;
    triangles[1].has_both_windings = true;
    const MeshTopology topology = find_topology(triangles, testing::edges_of(triangles));
    EXPECT_EQ(closed(topology), std::vector<bool>{false});
    EXPECT_EQ(topology.open_edges, 4U);
}

} // namespace
} // namespace springdrive::contact
