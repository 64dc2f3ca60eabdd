// Covers engine/contact/mesh/boundary_stitching.cpp and engine/contact/mesh/boundary_vertices.cpp.
#include "engine/contact/mesh/boundary_stitching.h"

#include "engine/contact/mesh/boundary_vertices.h"
#include "tests/engine/contact/mesh/meshes.h"

#include <gtest/gtest.h>

#include <set>

namespace springdrive::contact {
namespace {

using testing::edges_of;
using testing::mesh_of;
using testing::shaken;
using testing::unshared;

constexpr double kCrackTolerance_m = 5e-6;

ClosedCracks closed_cracks(const TriangleSoup &soup, PreparationAllowance &allowance,
                           unsigned threads = 1) {
    const std::vector<MeshTriangle> triangles = mesh_of(soup.triangles);
    return close_cracks(triangles, edges_of(triangles), soup.vertices_m, kCrackTolerance_m,
                        allowance, threads);
}

ClosedCracks closed_cracks(const TriangleSoup &soup, unsigned threads = 1) {
    PreparationAllowance allowance(soup.triangles.size());
    return closed_cracks(soup, allowance, threads);
}

std::vector<VertexTriple> welded(const TriangleSoup &soup, const ClosedCracks &closed) {
    std::vector<VertexTriple> triples = soup.triangles;
    for (VertexTriple &triple : triples) {
        for (std::uint32_t &vertex : triple) {
            vertex = closed.stands_for[vertex];
        }
    }
    return triples;
}

void expect_no_triangle_collapsed(const std::vector<VertexTriple> &triples) {
    for (const auto &[a, b, c] : triples) {
        ASSERT_TRUE(a != b && b != c && c != a);
    }
}

void expect_moves_within_tolerance(const TriangleSoup &soup, const ClosedCracks &closed) {
    double largest_m = 0.0;
    std::size_t moved = 0;
    for (std::size_t i = 0; i < soup.vertices_m.size(); ++i) {
        const std::uint32_t head = closed.stands_for[i];
        ASSERT_EQ(closed.stands_for[head], head);
        largest_m = std::max(largest_m, (soup.vertices_m[i] - soup.vertices_m[head]).norm());
        moved += head != i ? 1 : 0;
    }
    EXPECT_LE(largest_m, kCrackTolerance_m);
    EXPECT_EQ(closed.largest_move_m, largest_m);
    EXPECT_EQ(closed.moved_vertices, moved);
}

TEST(BoundaryVertices, HasTheEndsOfOpenEdgesAndAllTrianglesThere) {
    std::mt19937_64 random(1);
    TriangleSoup soup = testing::icosphere(2, 0.03);
    std::ranges::shuffle(soup.triangles, random);
    soup.triangles.resize(200);
    const std::vector<MeshTriangle> triangles = mesh_of(soup.triangles);
    const BoundaryVertices rim(triangles, edges_of(triangles), soup.vertices_m);
    std::set<std::uint32_t> expected;
    for (const auto &[edge, counts] : testing::edge_counts(soup.triangles)) {
        if (counts[0] + counts[1] == 1) {
            expected.insert({edge.first, edge.second});
        }
    }
    ASSERT_EQ(rim.size(), expected.size());
    for (std::uint32_t i = 0; i < rim.size(); ++i) {
        EXPECT_TRUE(expected.contains(rim.vertex(i)));
        EXPECT_EQ(rim.number_of(rim.vertex(i)), i);
        std::set<std::uint32_t> around;
        for (std::uint32_t t = 0; t < triangles.size(); ++t) {
            if (std::ranges::count(triangles[t].vertices, rim.vertex(i)) > 0) {
                around.insert(t);
            }
        }
        const auto found = rim.triangles_at(i);
        EXPECT_EQ(std::set<std::uint32_t>(found.begin(), found.end()), around);
    }
}

TEST(BoundaryStitching, LeavesAClosedMeshAndAPlainSheetAlone) {
    EXPECT_EQ(closed_cracks(testing::icosphere(3, 0.03)).moved_vertices, 0U);
    TriangleSoup half = testing::icosphere(3, 0.03);
    half.triangles.resize(half.triangles.size() / 2);
    EXPECT_EQ(closed_cracks(half).moved_vertices, 0U);
}

TEST(BoundaryStitching, ClosesASphereOfPerturbedTriangles) {
    std::mt19937_64 random(1);
    for (int level = 0; level <= 4; ++level) {
        const TriangleSoup soup =
            shaken(unshared(testing::bumpy_sphere(level, 0.03)), 1e-6, random);
        const ClosedCracks closed = closed_cracks(soup);
        EXPECT_TRUE(testing::is_watertight(welded(soup, closed)));
        expect_moves_within_tolerance(soup, closed);
        EXPECT_LE(closed.largest_move_m, 2e-6);
    }
}

TEST(BoundaryStitching, ClosesASphereWhoseEdgesAreHardlyLongerThanTheTolerance) {
    std::mt19937_64 random(1);
    // Edges of 8 to 10 µm, corners up to 1 µm from where they belong.
    const TriangleSoup soup = shaken(unshared(testing::icosphere(4, 1.2e-4)), 1e-6, random);
    const ClosedCracks closed = closed_cracks(soup);
    EXPECT_TRUE(testing::is_watertight(welded(soup, closed)));
    expect_moves_within_tolerance(soup, closed);
}

TEST(BoundaryStitching, ClosesAFanOfManyTriangles) {
    std::mt19937_64 random(1);
    TriangleSoup soup;
    constexpr int kTriangles = 300;
    for (int i = 0; i < kTriangles; ++i) {
        const auto at = [](int j) {
            const double angle = 2.0 * 3.14159265358979323846 * (j % kTriangles) / kTriangles;
            return Vector3(0.05 * std::cos(angle), 0.0, 0.05 * std::sin(angle));
        };
        testing::add_triangle(soup, {Vector3(0.0, 0.01, 0.0), at(i), at(i + 1)});
        testing::add_triangle(soup, {Vector3(0.0, -0.01, 0.0), at(i + 1), at(i)});
    }
    soup = shaken(soup, 1e-6, random);
    EXPECT_TRUE(testing::is_watertight(welded(soup, closed_cracks(soup))));
}

/// Two strips of squares, `gap_m` apart along x = 0.
TriangleSoup slit(double gap_m) {
    const auto half = [](double x, double sign) {
        TriangleSoup soup = testing::sheet(1, 0.005);
        for (Vector3 &vertex : soup.vertices_m) {
            vertex.x() = x + sign * (vertex.x() + 0.005);
        }
        return soup;
    };
    return testing::joined(half(0.0, -1.0), half(gap_m, 1.0));
}

std::size_t welds_over_slit(double gap_m) {
    const TriangleSoup soup = slit(gap_m);
    const ClosedCracks closed = closed_cracks(soup);
    std::size_t across = 0;
    for (std::uint32_t i = 0; i < soup.vertices_m.size(); ++i) {
        across += (i < 6) != (closed.stands_for[i] < 6) ? 1 : 0;
    }
    return across;
}

TEST(BoundaryStitching, ClosesASlitOfTheToleranceAndNoWiderOne) {
    EXPECT_GT(welds_over_slit(0.99 * kCrackTolerance_m), 0U);
    EXPECT_EQ(welds_over_slit(1.01 * kCrackTolerance_m), 0U);
}

TEST(BoundaryStitching, CollapsesNoTriangleHoweverSmall) {
    std::mt19937_64 random(1);
    for (const double size_m : {1e-6, 3e-6, 1e-5, 2e-5, 1e-4}) {
        for (int round = 0; round < 20; ++round) {
            const TriangleSoup soup = testing::random_soup(random, 200, 3e-5, size_m);
            const ClosedCracks closed = closed_cracks(soup);
            expect_no_triangle_collapsed(welded(soup, closed));
            expect_moves_within_tolerance(soup, closed);
        }
    }
}

TEST(BoundaryStitching, LeavesAFineScanWithAHoleAsItIs) {
    TriangleSoup scan = testing::icosphere(4, 2.5e-4); // edges of 17 to 21 µm
    scan.triangles.resize(scan.triangles.size() * 3 / 4);
    EXPECT_EQ(closed_cracks(scan).moved_vertices, 0U);
}

TEST(BoundaryStitching, TerminatesWhereAThousandVerticesCoincide) {
    std::mt19937_64 random(1);
    const TriangleSoup soup = testing::random_soup(random, 1000, 1e-6, 2e-6);
    expect_no_triangle_collapsed(welded(soup, closed_cracks(soup)));
}

} // namespace
} // namespace springdrive::contact
