// Covers engine/contact/mesh/repeated_triangles.cpp.
#include "engine/contact/mesh/repeated_triangles.h"

#include "tests/engine/contact/mesh/meshes.h"

#include <gtest/gtest.h>

#include <set>

namespace springdrive::contact {
namespace {

using testing::edges_of;
using testing::mesh_of;

struct RepeatOutcome {
    std::vector<MeshTriangle> triangles;
    RepeatedTriangles repeated;
};

RepeatOutcome after_dropping(std::vector<MeshTriangle> triangles,
                             const std::vector<std::uint16_t> &materials, unsigned threads = 1) {
    const EdgeTable edges = edges_of(triangles);
    RepeatedTriangles repeated = drop_repeated_triangles(triangles, edges, materials, threads);
    return {std::move(triangles), std::move(repeated)};
}

VertexTriple lowest_first(VertexTriple vertices) {
    std::rotate(vertices.begin(), std::ranges::min_element(vertices), vertices.end());
    return vertices;
}

VertexTriple other_side(VertexTriple vertices) {
    std::swap(vertices[1], vertices[2]);
    return lowest_first(vertices);
}

/// Winding and material, which determine the contact with these triangles.
using Felt = std::set<std::pair<VertexTriple, std::uint16_t>>;

Felt felt(const std::vector<MeshTriangle> &triangles, const std::vector<std::uint16_t> &materials) {
    Felt result;
    for (const MeshTriangle &triangle : triangles) {
        const std::uint16_t material = materials[triangle.triangle];
        result.emplace(lowest_first(triangle.vertices), material);
        if (triangle.has_both_windings) {
            result.emplace(other_side(triangle.vertices), material);
        }
    }
    return result;
}

TEST(RepeatedTriangles, LeavesAMeshWithoutAnyAlone) {
    const RepeatOutcome outcome =
        after_dropping(mesh_of({{0, 1, 2}, {0, 2, 3}, {1, 0, 3}}), {0, 0, 0});
    EXPECT_EQ(outcome.triangles.size(), 3U);
    EXPECT_TRUE(outcome.repeated.same_winding.empty());
    EXPECT_TRUE(outcome.repeated.merged.empty());
}

TEST(RepeatedTriangles, KeepsTheFirstOfOneWinding) {
    const RepeatOutcome outcome =
        after_dropping(mesh_of({{0, 1, 2}, {2, 0, 1}, {1, 2, 0}}), {0, 1, 0});
    ASSERT_EQ(outcome.triangles.size(), 1U);
    EXPECT_EQ(outcome.triangles.front().triangle, 0U);
    EXPECT_FALSE(outcome.triangles.front().has_both_windings);
    EXPECT_EQ(outcome.repeated.same_winding, (std::vector<std::uint32_t>{1, 2}));
}

TEST(RepeatedTriangles, MergesBothWindings) {
    const RepeatOutcome outcome = after_dropping(mesh_of({{0, 1, 2}, {0, 2, 1}}), {0, 0});
    ASSERT_EQ(outcome.triangles.size(), 1U);
    EXPECT_TRUE(outcome.triangles.front().has_both_windings);
    EXPECT_EQ(outcome.repeated.merged, std::vector<std::uint32_t>{1});
}

TEST(RepeatedTriangles, KeepsBothSidesOfDifferentMaterials) {
    const RepeatOutcome outcome = after_dropping(mesh_of({{0, 1, 2}, {0, 2, 1}}), {0, 1});
    ASSERT_EQ(outcome.triangles.size(), 2U);
    EXPECT_FALSE(outcome.triangles.front().has_both_windings);
}

TEST(RepeatedTriangles, KeepsBothWindingsOfWhatWasMergedBefore) {
    std::vector<MeshTriangle> triangles = mesh_of({{0, 1, 2}, {0, 1, 2}});
    triangles[1].has_both_windings = true;
    const RepeatOutcome outcome = after_dropping(triangles, {0, 0});
    ASSERT_EQ(outcome.triangles.size(), 1U);
    EXPECT_TRUE(outcome.triangles.front().has_both_windings);
}

TEST(RepeatedTriangles, LeavesOneOfEachAndEverySideTouchable) {
    std::mt19937_64 random(1);
    for (int round = 0; round < 500; ++round) {
        std::vector<VertexTriple> triples;
        std::vector<std::uint16_t> materials;
        for (int i = 0; i < 40; ++i) {
            VertexTriple triple = {0, 1, 2};
            std::array<std::uint32_t, 5> vertices = {0, 1, 2, 3, 4};
            std::ranges::shuffle(vertices, random);
            std::copy_n(vertices.begin(), 3, triple.begin());
            triples.push_back(triple);
            materials.push_back(static_cast<std::uint16_t>(random() % 4 == 0 ? 1 : 0));
        }
        const std::vector<MeshTriangle> before = mesh_of(triples);
        const RepeatOutcome outcome =
            after_dropping(before, materials, static_cast<unsigned>(1 + round % 3));

        // By brute force: of each winding the material of its first triangle.
        Felt expected;
        std::set<VertexTriple> seen;
        for (const MeshTriangle &triangle : before) {
            if (seen.insert(lowest_first(triangle.vertices)).second) {
                expected.emplace(lowest_first(triangle.vertices), materials[triangle.triangle]);
            }
        }
        ASSERT_EQ(felt(outcome.triangles, materials), expected);
        ASSERT_EQ(outcome.triangles.size() + outcome.repeated.same_winding.size() +
                      outcome.repeated.merged.size(),
                  before.size());
        std::set<VertexTriple> windings;
        for (const MeshTriangle &triangle : outcome.triangles) {
            ASSERT_TRUE(windings.insert(lowest_first(triangle.vertices)).second);
        }
    }
}

TEST(RepeatedTriangles, HandlesAHundredThousandCopies) {
    std::vector<VertexTriple> triples(100000, {0, 1, 2});
    triples.push_back({0, 2, 1});
    const RepeatOutcome outcome =
        after_dropping(mesh_of(triples), std::vector<std::uint16_t>(triples.size(), 0), 2);
    EXPECT_EQ(outcome.triangles.size(), 1U);
    EXPECT_EQ(outcome.repeated.same_winding.size(), 99999U);
}

} // namespace
} // namespace springdrive::contact
