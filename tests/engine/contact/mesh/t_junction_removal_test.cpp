// Covers engine/contact/mesh/t_junction_removal.cpp.
#include "engine/contact/mesh/t_junction_removal.h"

#include "tests/engine/contact/mesh/meshes.h"

#include <gtest/gtest.h>

#include <set>

namespace springdrive::contact {
namespace {

using testing::edges_of;
using testing::mesh_of;

constexpr double kSplitTolerance_m = 5e-6;

struct SplitOutcome {
    std::vector<MeshTriangle> triangles;
    std::vector<VertexTriple> triples;
    SplitEdges split;
};

SplitOutcome after_splitting(const std::vector<VertexTriple> &triples,
                             const std::vector<Vector3> &vertices_m, unsigned threads = 1) {
    SplitOutcome outcome{mesh_of(triples), {}, {}};
    const EdgeTable edges = edges_of(outcome.triangles);
    PreparationAllowance allowance(triples.size());
    outcome.split =
        split_edges(outcome.triangles, edges, vertices_m, kSplitTolerance_m, allowance, threads);
    for (const MeshTriangle &triangle : outcome.triangles) {
        outcome.triples.push_back(triangle.vertices);
    }
    return outcome;
}

double area_m2(const VertexTriple &triple, const std::vector<Vector3> &vertices_m) {
    const auto &[a, b, c] = triple;
    return 0.5 * (vertices_m[b] - vertices_m[a]).cross(vertices_m[c] - vertices_m[a]).norm();
}

/// Edges used by only one triangle.
std::set<std::pair<std::uint32_t, std::uint32_t>> open_edges(const std::vector<VertexTriple> &t) {
    std::set<std::pair<std::uint32_t, std::uint32_t>> open;
    for (const auto &[edge, counts] : testing::edge_counts(t)) {
        if (counts[0] + counts[1] == 1) {
            open.insert(edge);
        }
    }
    return open;
}

TEST(TJunctionRemoval, LeavesMeshesWithoutTJunctionsAlone) {
    const TriangleSoup sphere = testing::icosphere(2, 0.03);
    EXPECT_EQ(after_splitting(sphere.triangles, sphere.vertices_m).split.split_triangles, 0U);
    std::vector<VertexTriple> half = sphere.triangles;
    half.resize(100);
    EXPECT_EQ(after_splitting(half, sphere.vertices_m).triples, half);
}

TEST(TJunctionRemoval, RoutesAnEdgeThroughTheVerticesOnIt) {
    // One triangle above the line from 0 to 1, three below it that share the line's 3 and 4.
    const std::vector<Vector3> vertices_m = {{0.0, 0.0, 0.0},     {0.03, 0.0, 0.0},
                                             {0.01, 0.02, 0.0},   {0.02, 1e-6, 1e-6},
                                             {0.01, -2e-6, 1e-6}, {0.015, -0.02, 0.0}};
    const SplitOutcome outcome =
        after_splitting({{0, 1, 2}, {0, 5, 4}, {4, 5, 3}, {3, 5, 1}}, vertices_m);
    EXPECT_EQ(outcome.split.split_triangles, 1U);
    EXPECT_DOUBLE_EQ(outcome.split.largest_move_m, std::sqrt(5.0) * 1e-6);
    ASSERT_EQ(outcome.triangles.size(), 6U);
    EXPECT_EQ(outcome.triangles[4].triangle, 0U);
    EXPECT_EQ(outcome.triangles[5].triangle, 0U);
    const std::set<std::pair<std::uint32_t, std::uint32_t>> outline = {
        {0, 2}, {1, 2}, {0, 5}, {1, 5}};
    EXPECT_EQ(open_edges(outcome.triples), outline);
}

TEST(TJunctionRemoval, ReachesAsFarAsTheToleranceAndNoFarther) {
    for (const double share : {0.99, 1.01}) {
        const std::vector<Vector3> vertices_m = {
            {0.0, 0.0, 0.0},   {0.03, 0.0, 0.0},
            {0.01, 0.02, 0.0}, {0.02, -share * kSplitTolerance_m, 0.0},
            {0.0, -0.02, 0.0}, {0.03, -0.02, 0.0}};
        const SplitOutcome outcome = after_splitting({{0, 1, 2}, {3, 4, 5}}, vertices_m);
        EXPECT_EQ(outcome.split.split_triangles, share < 1.0 ? 1U : 0U);
    }
}

TEST(TJunctionRemoval, DividesAllThreeSidesAndKeepsAreaAndWinding) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> share(0.05, 0.95);
    for (int round = 0; round < 200; ++round) {
        std::vector<Vector3> vertices_m = {{0.0, 0.0, 0.0}, {0.03, 0.0, 0.0}, {0.01, 0.02, 0.0}};
        std::vector<VertexTriple> triples = {{0, 1, 2}};
        std::size_t on_sides = 0;
        for (std::uint32_t side = 0; side < 3; ++side) {
            for (std::size_t i = random() % 5; i > 0; --i) {
                const double t = share(random);
                const Vector3 at = (1.0 - t) * vertices_m[side] + t * vertices_m[(side + 1) % 3];
                const auto first = static_cast<std::uint32_t>(vertices_m.size());
                // A triangle that touches the side with one corner, from outside the plane.
                vertices_m.push_back(at);
                vertices_m.emplace_back(at + Vector3(0.001, 0.0, 0.01));
                vertices_m.emplace_back(at + Vector3(-0.001, 0.0, 0.01));
                triples.push_back({first, first + 1, first + 2});
                ++on_sides;
            }
        }
        const SplitOutcome outcome = after_splitting(triples, vertices_m);
        std::vector<VertexTriple> pieces;
        double area = 0.0;
        for (const MeshTriangle &triangle : outcome.triangles) {
            if (triangle.triangle == 0) {
                const auto &[a, b, c] = triangle.vertices;
                pieces.push_back(triangle.vertices);
                area += area_m2(triangle.vertices, vertices_m);
                EXPECT_GT((vertices_m[b] - vertices_m[a]).cross(vertices_m[c] - vertices_m[a]).z(),
                          0.0);
            }
        }
        EXPECT_EQ(pieces.size(), 1 + on_sides);
        EXPECT_EQ(open_edges(pieces).size(), 3 + on_sides);
        EXPECT_NEAR(area, 3e-4, 1e-17);
    }
}

TEST(TJunctionRemoval, DividesALongEdgeByThousandsOfVertices) {
    std::vector<Vector3> vertices_m = {{0.0, 0.0, 0.0}, {0.1, 0.0, 0.0}, {0.05, 0.05, 0.0}};
    std::vector<VertexTriple> triples = {{0, 1, 2}};
    constexpr std::uint32_t kCells = 5000;
    vertices_m.emplace_back(0.05, -0.05, 0.0);
    for (std::uint32_t i = 1; i < kCells; ++i) {
        vertices_m.emplace_back(0.1 * i / kCells, 0.0, 0.0);
    }
    for (std::uint32_t i = 0; i < kCells; ++i) {
        triples.push_back({i + 1 == kCells ? 1 : 4 + i, i == 0 ? 0 : 3 + i, 3});
    }
    const SplitOutcome outcome = after_splitting(triples, vertices_m, 2);
    EXPECT_EQ(outcome.triangles.size(), 2U * kCells);
    EXPECT_EQ(open_edges(outcome.triples).size(), 4U);
}

TEST(TJunctionRemoval, IsTheSameForAnyNumberOfThreads) {
    std::mt19937_64 random(1);
    const TriangleSoup soup = testing::random_soup(random, 500, 1e-4, 1e-4);
    const SplitOutcome one = after_splitting(soup.triangles, soup.vertices_m, 1);
    EXPECT_GT(one.split.split_triangles, 0U);
    EXPECT_EQ(after_splitting(soup.triangles, soup.vertices_m, 2).triples, one.triples);
    EXPECT_EQ(after_splitting(soup.triangles, soup.vertices_m, 3).triples, one.triples);
}

TEST(TJunctionRemoval, NeverMakesATriangleOfTwoCorners) {
    std::mt19937_64 random(1);
    for (int round = 0; round < 50; ++round) {
        const TriangleSoup soup = testing::random_soup(random, 100, 2e-5, 2e-5);
        for (const auto &[a, b, c] : after_splitting(soup.triangles, soup.vertices_m).triples) {
            ASSERT_TRUE(a != b && b != c && c != a);
        }
    }
}

} // namespace
} // namespace springdrive::contact
