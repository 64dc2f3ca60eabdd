// Covers engine/contact/mesh/edge_table.cpp.
#include "engine/contact/mesh/edge_table.h"

#include "tests/engine/contact/mesh/meshes.h"

#include <gtest/gtest.h>

#include <tuple>

namespace springdrive::contact {
namespace {

using testing::edges_of;
using testing::mesh_of;

/// Three different vertices of `count`, at random.
VertexTriple random_triple(std::mt19937_64 &random, std::uint32_t count) {
    std::uniform_int_distribution<std::uint32_t> vertex(0, count - 1);
    VertexTriple triple{};
    do {
        triple = {vertex(random), vertex(random), vertex(random)};
    } while (triple[0] == triple[1] || triple[1] == triple[2] || triple[2] == triple[0]);
    return triple;
}

std::vector<MeshTriangle> random_mesh(std::mt19937_64 &random, int triangles,
                                      std::uint32_t vertices) {
    std::vector<VertexTriple> triples;
    triples.reserve(static_cast<std::size_t>(triangles));
    for (int i = 0; i < triangles; ++i) {
        triples.push_back(random_triple(random, vertices));
    }
    return mesh_of(triples);
}

TEST(EdgeTable, HasNoEdgesWithoutTriangles) {
    edges_of({}).for_each([](const Edge &) { ADD_FAILURE(); });
    EXPECT_EQ(count_open(edges_of({})), 0U);
}

TEST(EdgeTable, HoldsEveryUseOfEveryEdge) {
    std::mt19937_64 random(1);
    for (int i = 0; i < 200; ++i) {
        const std::uint32_t vertices = 3 + static_cast<std::uint32_t>(random() % 20);
        const std::vector<MeshTriangle> mesh = random_mesh(random, 40, vertices);
        std::vector<VertexTriple> triples;
        triples.reserve(mesh.size());
        for (const MeshTriangle &triangle : mesh) {
            triples.push_back(triangle.vertices);
        }
        auto expected = testing::edge_counts(triples);
        std::size_t open = 0;
        const EdgeTable edges = edges_of(mesh);
        edges.for_each([&](const Edge &edge) {
            std::array<int, 2> counts{};
            for (const EdgeUse &use : edge.uses) {
                const VertexTriple &corners = mesh[use.triangle()].vertices;
                const std::uint32_t from = corners[use.side()];
                const std::uint32_t to = corners[(use.side() + 1) % 3];
                ASSERT_EQ(std::min(from, to), edge.lower);
                ASSERT_EQ(std::max(from, to), edge.upper());
                ASSERT_EQ(from < to, use.is_forward());
                ++counts[use.is_forward() ? 0 : 1];
            }
            ASSERT_EQ(counts, (expected.at({edge.lower, edge.upper()})));
            ASSERT_EQ(edges.uses_of(edge.upper(), edge.lower).data(), edge.uses.data());
            ASSERT_EQ(edges.uses_of(edge.lower, edge.upper()).size(), edge.uses.size());
            expected.erase({edge.lower, edge.upper()});
            open += edge.uses.size() == 1 ? 1 : 0;
        });
        EXPECT_TRUE(expected.empty());
        EXPECT_EQ(count_open(edges), open);
    }
}

TEST(EdgeTable, HasNoUsesForVerticesWithoutAnEdge) {
    const EdgeTable edges = edges_of(mesh_of({{0, 1, 2}, {0, 2, 4}}));
    EXPECT_TRUE(edges.uses_of(1, 4).empty());
    EXPECT_TRUE(edges.uses_of(0, 3).empty());
}

TEST(EdgeTable, IsTheSameForAnyNumberOfThreads) {
    std::mt19937_64 random(1);
    const std::vector<MeshTriangle> mesh = random_mesh(random, 2000, 300);
    using Use = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t, std::uint32_t, bool>;
    const auto listed = [&mesh](unsigned threads) {
        std::vector<Use> uses;
        edges_of(mesh, threads).for_each([&](const Edge &edge) {
            for (const EdgeUse &use : edge.uses) {
                uses.emplace_back(edge.lower, use.upper(), use.triangle(), use.side(),
                                  use.is_forward());
            }
        });
        return uses;
    };
    EXPECT_EQ(listed(2), listed(1));
    EXPECT_EQ(listed(7), listed(1));
}

} // namespace
} // namespace springdrive::contact
