// Covers engine/contact/mesh_topology.cpp.
#include "engine/contact/mesh_topology.h"

#include "tests/engine/contact/soups.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace springdrive {
namespace {

const std::vector<VertexTriple> kTetrahedron = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

TEST(MeshTopology, OfNothingIsNothing) {
    const MeshTopology topology = find_topology({});
    EXPECT_TRUE(topology.is_closed.empty());
    EXPECT_EQ(topology.open_edges, 0U);
}

TEST(MeshTopology, FindsATetrahedronClosed) {
    const MeshTopology topology = find_topology(kTetrahedron);
    EXPECT_EQ(topology.is_closed, std::vector<bool>{true});
    EXPECT_EQ(topology.open_edges, 0U);
    EXPECT_EQ(topology.non_manifold_edges, 0U);
}

TEST(MeshTopology, FindsATetrahedronWithoutOneFaceOpen) {
    std::vector<VertexTriple> triangles = kTetrahedron;
    triangles.pop_back();
    const MeshTopology topology = find_topology(triangles);
    EXPECT_EQ(topology.is_closed, std::vector<bool>{false});
    EXPECT_EQ(topology.open_edges, 3U);
}

TEST(MeshTopology, DoesNotTrustAFaceThatIsTurnedOver) {
    std::vector<VertexTriple> triangles = kTetrahedron;
    std::swap(triangles[2][0], triangles[2][1]);
    const MeshTopology topology = find_topology(triangles);
    EXPECT_EQ(topology.is_closed, std::vector<bool>{false});
    EXPECT_EQ(topology.open_edges, 0U);
}

TEST(MeshTopology, KeepsSolidsThatShareAnEdgeClosed) {
    std::vector<VertexTriple> triangles = kTetrahedron;
    // Another tetrahedron, on the edge 0-1 of the first.
    triangles.insert(triangles.end(), {{0, 4, 1}, {0, 1, 5}, {1, 4, 5}, {4, 0, 5}});
    const MeshTopology topology = find_topology(triangles);
    EXPECT_EQ(topology.is_closed, std::vector<bool>{true});
    EXPECT_EQ(topology.non_manifold_edges, 1U);
}

TEST(MeshTopology, DoesNotConnectOverAVertex) {
    std::vector<VertexTriple> triangles = kTetrahedron;
    triangles.insert(triangles.end(), {{0, 5, 4}, {0, 4, 6}, {4, 5, 6}}); // and open
    const MeshTopology topology = find_topology(triangles);
    EXPECT_EQ(topology.is_closed, (std::vector<bool>{true, false}));
    EXPECT_EQ(topology.component_of_triangle, (std::vector<std::uint32_t>{0, 0, 0, 0, 1, 1, 1}));
}

TEST(MeshTopology, ConnectsALongStripInAnyOrder) {
    std::vector<VertexTriple> strip;
    for (std::uint32_t i = 0; i < 5000; ++i) {
        strip.push_back(i % 2 == 0 ? VertexTriple{i, i + 1, i + 2} : VertexTriple{i + 1, i, i + 2});
    }
    std::mt19937_64 random(1);
    std::ranges::shuffle(strip, random);
    const MeshTopology topology = find_topology(strip);
    EXPECT_EQ(topology.is_closed, std::vector<bool>{false});
    EXPECT_EQ(topology.open_edges, 5002U); // Euler: a disc of n triangles has n + 2 border edges
}

TEST(MeshTopology, FindsASphereClosed) {
    const MeshTopology topology = find_topology(testing::icosphere(4, 1.0).triangles);
    EXPECT_EQ(topology.is_closed, std::vector<bool>{true});
    EXPECT_EQ(topology.open_edges, 0U);
}

} // namespace
} // namespace springdrive
