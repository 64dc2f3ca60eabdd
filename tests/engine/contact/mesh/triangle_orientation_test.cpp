// Covers engine/contact/mesh/triangle_orientation.cpp.
#include "engine/contact/mesh/triangle_orientation.h"

#include "tests/engine/contact/mesh/meshes.h"

#include <gtest/gtest.h>

namespace springdrive::contact {
namespace {

using testing::bumpy_sphere;
using testing::edges_of;
using testing::mesh_of;

struct OrientationOutcome {
    std::vector<VertexTriple> triples;
    TurnedTriangles turned;
};

OrientationOutcome oriented(std::vector<MeshTriangle> triangles,
                            const std::vector<Vector3> &vertices_m) {
    const EdgeTable edges = edges_of(triangles);
    OrientationOutcome outcome{{}, orient_triangles(triangles, edges, vertices_m)};
    for (const MeshTriangle &triangle : triangles) {
        outcome.triples.push_back(triangle.vertices);
    }
    return outcome;
}

OrientationOutcome oriented(const TriangleSoup &soup) {
    return oriented(mesh_of(soup.triangles), soup.vertices_m);
}

double volume_m3(const std::vector<VertexTriple> &triples, const std::vector<Vector3> &vertices_m) {
    double volume = 0.0;
    for (const auto &[a, b, c] : triples) {
        volume += vertices_m[a].dot(vertices_m[b].cross(vertices_m[c])) / 6.0;
    }
    return volume;
}

/// How many triangles differ in winding from those given.
std::size_t differences(const std::vector<VertexTriple> &a, const std::vector<VertexTriple> &b) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        VertexTriple turned = b[i];
        std::rotate(turned.begin(), std::ranges::find(turned, a[i][0]), turned.end());
        count += turned == a[i] ? 0 : 1;
    }
    return count;
}

TEST(TriangleOrientation, LeavesConsistentMeshesUnchanged) {
    const TriangleSoup body = bumpy_sphere(2, 0.03);
    const TriangleSoup room = testing::turned_inside_out(body);
    for (const TriangleSoup &soup : {body, room}) {
        const OrientationOutcome outcome = oriented(soup);
        EXPECT_EQ(outcome.turned.of_one_winding, 0U);
        EXPECT_EQ(outcome.triples, soup.triangles);
    }
}

TEST(TriangleOrientation, TurnsTheFewInABodyAndInARoom) {
    std::mt19937_64 random(1);
    const TriangleSoup body = bumpy_sphere(3, 0.03);
    for (const TriangleSoup &right : {body, testing::turned_inside_out(body)}) {
        for (int round = 0; round < 10; ++round) {
            const TriangleSoup disturbed =
                testing::partly_turned(right, 0.05 + 0.02 * round, random);
            const OrientationOutcome outcome = oriented(disturbed);
            EXPECT_EQ(differences(outcome.triples, right.triangles), 0U);
            EXPECT_EQ(outcome.turned.of_one_winding,
                      differences(disturbed.triangles, right.triangles));
        }
    }
}

TEST(TriangleOrientation, TurnsABodyOfRandomWindingOutwards) {
    std::mt19937_64 random(1);
    for (int round = 0; round < 20; ++round) {
        const TriangleSoup body = testing::shuffled(bumpy_sphere(3, 0.03), random);
        const OrientationOutcome outcome = oriented(testing::partly_turned(body, 0.5, random));
        EXPECT_TRUE(testing::is_watertight(outcome.triples));
        EXPECT_GT(volume_m3(outcome.triples, body.vertices_m), 0.0);
    }
}

TEST(TriangleOrientation, CountsAreaNotTriangles) {
    // An octahedron drawn out upwards: its four upper triangles have most of the area.
    const std::vector<Vector3> vertices_m = {{0.01, 0, 0},  {-0.01, 0, 0}, {0, 0, 0.01},
                                             {0, 0, -0.01}, {0, 0.1, 0},   {0, -0.001, 0}};
    const std::vector<VertexTriple> upper_inward = {{4, 0, 2}, {4, 2, 1}, {4, 1, 3}, {4, 3, 0}};
    std::vector<VertexTriple> triples = upper_inward;
    triples.insert(triples.end(), {{5, 0, 2}, {5, 2, 1}, {5, 1, 3}, {5, 3, 0}});
    const OrientationOutcome outcome = oriented(mesh_of(triples), vertices_m);
    EXPECT_TRUE(testing::is_watertight(outcome.triples));
    EXPECT_EQ(outcome.turned.of_one_winding, 4U);
    EXPECT_TRUE(std::equal(upper_inward.begin(), upper_inward.end(), outcome.triples.begin()));
}

TEST(TriangleOrientation, GivesASheetTheWindingOfItsLargerPart) {
    std::mt19937_64 random(1);
    TriangleSoup sheet;
    for (std::uint32_t i = 0; i < 50; ++i) {
        sheet.vertices_m.emplace_back(0.01 * i, 0.0, 0.0);
        sheet.vertices_m.emplace_back(0.01 * i, 0.0, 0.02);
    }
    for (std::uint32_t i = 0; i < 48; ++i) {
        const bool is_turned = i < 20; // 5/12 of it: no clear majority, and no inside either
        sheet.triangles.push_back((i % 2 == 0) != is_turned
                                      ? std::array<std::uint32_t, 3>{i, i + 1, i + 2}
                                      : std::array<std::uint32_t, 3>{i + 1, i, i + 2});
    }
    const OrientationOutcome outcome = oriented(sheet);
    EXPECT_EQ(outcome.turned.of_one_winding, 20U);
    EXPECT_EQ(outcome.triples.back(), sheet.triangles.back());
}

TEST(TriangleOrientation, LeavesAMobiusStripUnchangedAndTurnsOtherPatches) {
    std::vector<VertexTriple> strip = testing::twisted_strip(9, 1);
    std::vector<VertexTriple> triples = strip;
    triples.insert(triples.end(), {{20, 22, 21}, {20, 21, 23}, {21, 22, 23}, {20, 22, 23}});
    std::mt19937_64 random(1);
    std::vector<Vector3> vertices_m;
    vertices_m.reserve(24);
    for (int i = 0; i < 24; ++i) {
        vertices_m.push_back(testing::random_vector(random, 0.1));
    }
    const OrientationOutcome outcome = oriented(mesh_of(triples), vertices_m);
    EXPECT_TRUE(std::equal(strip.begin(), strip.end(), outcome.triples.begin()));
    EXPECT_EQ(outcome.turned.of_one_winding, 1U);
    EXPECT_TRUE(testing::is_watertight(
        std::vector<VertexTriple>(outcome.triples.end() - 4, outcome.triples.end())));
}

TEST(TriangleOrientation, TurnsAStripOfTwoHalfTurns) {
    std::mt19937_64 random(1);
    TriangleSoup soup;
    soup.triangles = testing::twisted_strip(9, 2);
    for (int i = 0; i < 18; ++i) {
        soup.vertices_m.push_back(testing::random_vector(random, 0.1));
    }
    const OrientationOutcome outcome = oriented(testing::partly_turned(soup, 0.3, random));
    for (const auto &[edge, counts] : testing::edge_counts(outcome.triples)) {
        EXPECT_LE(std::max(counts[0], counts[1]), 1);
    }
}

TEST(TriangleOrientation, LetsTrianglesOfBothWindingsFollowWithoutAVote) {
    const TriangleSoup body = bumpy_sphere(2, 0.03);
    std::vector<MeshTriangle> triangles = mesh_of(body.triangles);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        if (i % 10 != 0) {
            triangles[i].has_both_windings = true;
            std::swap(triangles[i].vertices[0], triangles[i].vertices[1]);
        }
    }
    const OrientationOutcome outcome = oriented(triangles, body.vertices_m);
    EXPECT_EQ(differences(outcome.triples, body.triangles), 0U);
    EXPECT_EQ(outcome.turned.of_one_winding, 0U);
    EXPECT_EQ(outcome.turned.of_both, 288U);
}

} // namespace
} // namespace springdrive::contact
