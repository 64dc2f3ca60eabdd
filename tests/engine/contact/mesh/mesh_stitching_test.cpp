// Covers engine/contact/mesh/mesh_stitching.cpp, with vertex_search.cpp, and that no stage exceeds
// what it is allowed.
#include "base/input_error.h"
#include "engine/contact/mesh/mesh_stitching.h"
#include "engine/contact/mesh/vertex_search.h"
#include "tests/engine/contact/mesh/soups.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <vector>

namespace springdrive::contact {
namespace {

using testing::add_triangle;
using testing::edges_of;
using testing::mesh_of;
using testing::random_direction;
using testing::random_vector;
using testing::scattered_soup;
using testing::shaken;
using testing::soup_in_a_line;
using testing::unshared;

constexpr double kWeldTolerance_m = 1e-7;

std::vector<std::uint32_t> welded(const std::vector<Vector3> &vertices_m, double tolerance_m) {
    PreparationAllowance allowance(vertices_m.size());
    return weld_vertices(vertices_m, tolerance_m, allowance);
}

TEST(VertexWelding, MovesNoVertexByMoreThanTheToleranceAlongAChain) {
    std::vector<Vector3> chain;
    chain.reserve(100);
    for (int i = 0; i < 100; ++i) {
        chain.emplace_back(0.7 * kWeldTolerance_m * i, 0.0, 0.0);
    }
    const std::vector<std::uint32_t> stands_for = welded(chain, kWeldTolerance_m);
    for (std::size_t i = 0; i < chain.size(); ++i) {
        EXPECT_LE((chain[stands_for[i]] - chain[i]).norm(), kWeldTolerance_m);
    }
}

TEST(VertexWelding, FindsTheCopiesOfScatteredVerticesWhereverTheyLie) {
    std::mt19937_64 random(1);
    constexpr std::uint32_t kCount = 20000;
    std::vector<Vector3> vertices;
    for (std::uint32_t i = 0; i < kCount; ++i) {
        vertices.push_back(random_vector(random, 0.1)); // some 1e-3 m apart: never a pair
    }
    for (std::uint32_t i = 0; i < kCount; ++i) {
        vertices.emplace_back(vertices[i] + 0.99 * kWeldTolerance_m * random_direction(random));
    }
    const std::vector<std::uint32_t> stands_for = welded(vertices, kWeldTolerance_m);
    for (std::uint32_t i = 0; i < kCount; ++i) {
        ASSERT_EQ(stands_for[i], i);
        ASSERT_EQ(stands_for[kCount + i], i);
    }
}

TEST(VertexWelding, LeavesVerticesThatAreNotFiniteOrJustTooFarAlone) {
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const std::vector<Vector3> vertices = {{kNaN, 0, 0},       {kNaN, 0, 0},    {kInfinity, 0, 0},
                                           {0, 0, 1e300},      {0, 0, 1e300},   {0.0, 0.0, 0.0},
                                           {-0.0, -0.0, -0.0}, {1.01e-7, 0, 0}, {0, -1.01e-7, 0}};
    const std::vector<std::uint32_t> expected = {0, 1, 2, 3, 3, 5, 5, 7, 8};
    EXPECT_EQ(welded(vertices, kWeldTolerance_m), expected);
}

constexpr double kCrackTolerance_m = 5e-6;

ClosedCracks closed_cracks(const TriangleSoup &soup) {
    PreparationAllowance allowance(soup.triangles.size());
    const std::vector<MeshTriangle> triangles = mesh_of(soup.triangles);
    return close_cracks(triangles, edges_of(triangles), soup.vertices_m, kCrackTolerance_m,
                        allowance, 1);
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
    const TriangleSoup soup =
        shaken(testing::lathed({{0.0, -0.01}, {0.05, 0.0}, {0.0, 0.01}}, 300), 1e-6, random);
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

std::set<std::uint32_t> found_along(const PointTree &tree, const Vector3 &from_m,
                                    const Vector3 &to_m, double reach_m) {
    std::set<std::uint32_t> found;
    std::ignore =
        tree.visit_along(from_m, to_m, reach_m, [&](std::uint32_t point, double fraction, double) {
            EXPECT_TRUE(found.insert(point).second);
            EXPECT_GT(fraction, 0.0);
            EXPECT_LT(fraction, 1.0);
            return false;
        });
    return found;
}

/// Round-off may decide about points this near to the border [m].
constexpr double kBorderRoundOff_m = 1e-14;

TEST(PointTree, FindsWhatASearchOfAllFinds) {
    std::mt19937_64 random(1);
    std::size_t found_in_all = 0;
    for (int round = 0; round < 200; ++round) {
        std::vector<Vector3> points_m;
        for (int i = 0; i < 200; ++i) {
            points_m.push_back(random_vector(random, 0.1));
            if (round % 2 == 0) { // all in a plane, many at the same height
                points_m.back()[2] = 0.0;
                points_m.back()[0] = std::round(100.0 * points_m.back()[0]) / 100.0;
            }
        }
        const PointTree tree(points_m);
        for (int i = 0; i < 20; ++i) {
            const Vector3 from_m = random_vector(random, 0.1);
            Vector3 to_m = random_vector(random, 0.1);
            to_m[i % 3] = i % 2 == 0 ? from_m[i % 3] : to_m[i % 3];
            const double reach_m = 0.02;
            const std::set<std::uint32_t> found = found_along(tree, from_m, to_m, reach_m);
            found_in_all += found.size();
            const Vector3 way = to_m - from_m;
            for (std::uint32_t point = 0; point < points_m.size(); ++point) {
                const double along_m = (points_m[point] - from_m).dot(way.normalized());
                const double beside_m = (points_m[point] - from_m).cross(way.normalized()).norm();
                const double inside_m =
                    std::min({along_m, way.norm() - along_m, reach_m - beside_m});
                if (std::abs(inside_m) > kBorderRoundOff_m) {
                    ASSERT_EQ(found.contains(point), inside_m > 0.0);
                }
            }
        }
    }
    EXPECT_GT(found_in_all, 10000U);
}

TEST(PointTree, StopsWhenToldTo) {
    const PointTree tree(std::vector<Vector3>(1000, Vector3(0.5, 0.0, 0.0)));
    int visits = 0;
    std::ignore = tree.visit_along(Vector3::Zero(), Vector3::UnitX(), 0.1,
                                   [&](std::uint32_t, double, double) { return ++visits == 3; });
    EXPECT_EQ(visits, 3);
}

TEST(PointTree, IsTheSameForAnyNumberOfThreads) {
    std::mt19937_64 random(1);
    std::vector<Vector3> points_m;
    while (points_m.size() < 50'000) {
        points_m.push_back(random_vector(random, 0.1));
    }
    const auto order = [&](unsigned threads) {
        std::vector<std::uint32_t> found;
        std::ignore = PointTree(points_m, threads)
                          .visit_along(Vector3::Zero(), Vector3::Constant(0.1), 0.02,
                                       [&](std::uint32_t point, double, double) {
                                           found.push_back(point);
                                           return false;
                                       });
        return found;
    };
    EXPECT_GT(order(1).size(), 100U);
    EXPECT_EQ(order(2), order(1));
    EXPECT_EQ(order(3), order(1));
}

constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

TriangleSoup cloud(std::mt19937_64 &random, int triangles) {
    return scattered_soup(random, triangles, {1e-5, 1e-5, 1e-5});
}

/// Sheets one above the other, so that each vertex is within the tolerance of several.
TriangleSoup stack(std::mt19937_64 &random, int sheets) {
    TriangleSoup soup;
    for (int i = 0; i < sheets; ++i) {
        Eigen::Isometry3d up = Eigen::Isometry3d::Identity();
        up.translation().y() = 1e-6 * i;
        soup = testing::joined(soup, testing::moved(testing::sheet(8, 0.05), up));
    }
    return shaken(testing::unshared(soup), 1e-6, random);
}

/// A cone of triangles by themselves.
TriangleSoup fan(std::mt19937_64 &random, int triangles) {
    return shaken(testing::lathed({{0.05, 0.0}, {0.0, 0.01}}, triangles), 1e-6, random);
}

/// Triangles by themselves, all with the edge from −50 mm to +50 mm on the y axis.
TriangleSoup book(std::mt19937_64 &random, int triangles) {
    TriangleSoup soup;
    for (int i = 0; i < triangles; ++i) {
        const double angle = 6.28318530717958647692 * i / triangles;
        add_triangle(soup, {Vector3(0.0, -0.05, 0.0), Vector3(0.0, 0.05, 0.0),
                            Vector3(0.05 * std::cos(angle), 0.0, 0.05 * std::sin(angle))});
    }
    return shaken(soup, 1e-6, random);
}

/// The corners replaced, without the triangles that collapse.
std::vector<MeshTriangle> replaced(const std::vector<MeshTriangle> &triangles,
                                   const std::vector<std::uint32_t> &stands_for) {
    std::vector<MeshTriangle> result;
    for (MeshTriangle triangle : triangles) {
        for (std::uint32_t &vertex : triangle.vertices) {
            vertex = stands_for[vertex];
        }
        const auto &[a, b, c] = triangle.vertices;
        if (a != b && b != c && c != a) {
            result.push_back(triangle);
        }
    }
    return result;
}

constexpr double kClosedGap_m = 5e-6;

/// The stages up to the closing of cracks.
std::vector<MeshTriangle> closed_mesh(const TriangleSoup &soup, PreparationAllowance &allowance,
                                      unsigned threads = 1) {
    const std::vector<MeshTriangle> triangles = replaced(
        testing::mesh_of(soup.triangles), weld_vertices(soup.vertices_m, 1e-7, allowance, threads));
    const EdgeTable edges(triangles, soup.vertices_m.size(), threads);
    return replaced(
        triangles, close_cracks(triangles, edges, soup.vertices_m, kClosedGap_m, allowance, threads)
                       .stands_for);
}

/// All stages that are bounded.
void run_stages(const TriangleSoup &soup, PreparationAllowance &allowance, unsigned threads = 1) {
    std::vector<MeshTriangle> triangles = closed_mesh(soup, allowance, threads);
    const EdgeTable edges(triangles, soup.vertices_m.size(), threads);
    static_cast<void>(
        split_edges(triangles, edges, soup.vertices_m, kClosedGap_m, allowance, threads));
}

std::uint64_t steps_for(const TriangleSoup &soup, unsigned threads = 1) {
    PreparationAllowance allowance(soup.triangles.size(), kUnlimited);
    run_stages(soup, allowance, threads);
    return allowance.taken();
}

std::string error_about(const TriangleSoup &soup, std::uint64_t allowed, unsigned threads = 1) {
    PreparationAllowance allowance(soup.triangles.size(), allowed);
    return error_text_of([&] { run_stages(soup, allowance, threads); });
}

TEST(PreparationAllowance, GrowsWithTheMeshUpToALimit) {
    const auto allows = [](std::size_t triangles, std::uint64_t steps) {
        return PreparationAllowance(triangles).take(steps);
    };
    EXPECT_TRUE(allows(0, 2'000'000'000));
    EXPECT_FALSE(allows(0, 2'000'000'001));
    EXPECT_TRUE(allows(1'000'000, 4'000'000'000));
    EXPECT_FALSE(allows(1'000'000, 4'000'000'001));
    EXPECT_TRUE(allows(kMaxTriangles, 10'000'000'000));
    EXPECT_FALSE(allows(kMaxTriangles, 10'000'000'001));
}

TEST(PreparationAllowance, RefusesWithBothNumbers) {
    const PreparationAllowance allowance(6000);
    const auto error = [&allowance](double needed_steps) {
        return error_text_of([&] { allowance.refuse("sort them", needed_steps); });
    };
    const std::string before = "preparing its 6000 triangles for touch needs ";
    const std::string after = " million steps, most of them to sort them; at most 2012 million are "
                              "allowed: ";
    EXPECT_TRUE(error(54'321'000'000.0).starts_with(before + "about 54321" + after));
    // An estimate below what is allowed would contradict the refusal.
    EXPECT_TRUE(error(2'011'000'000.0).starts_with(before + "more than 2012" + after));
}

TEST(PreparationAllowance, IsTakenFromAlikeByAnyNumberOfThreads) {
    std::mt19937_64 random(1);
    for (const TriangleSoup &soup :
         {soup_in_a_line(random, 100), cloud(random, 500), fan(random, 500)}) {
        const std::uint64_t needed = steps_for(soup);
        for (const unsigned threads : {1U, 2U, 3U}) {
            EXPECT_EQ(steps_for(soup, threads), needed);
            EXPECT_EQ(error_about(soup, needed, threads), "");
            EXPECT_EQ(error_about(soup, needed - 1, threads), error_about(soup, needed - 1));
            EXPECT_NE(error_about(soup, needed - 1, threads), "");
        }
    }
}

TEST(PreparationAllowance, IsRefusedInEveryStage) {
    std::mt19937_64 random(1);
    const TriangleSoup dense = cloud(random, 1000);
    const auto names = [](const std::string &error, const std::string &purpose) {
        return error.find("most of them to " + purpose + ";") != std::string::npos;
    };
    EXPECT_TRUE(names(error_about(dense, 1000), "find vertices at the same place"));
    PreparationAllowance welding(dense.triangles.size(), kUnlimited);
    static_cast<void>(weld_vertices(dense.vertices_m, 1e-7, welding));
    EXPECT_TRUE(
        names(error_about(dense, welding.taken() + 1000), "find vertices that nearly coincide"));
    PreparationAllowance closing(dense.triangles.size(), kUnlimited);
    static_cast<void>(closed_mesh(dense, closing)); // which ends with joining
    EXPECT_TRUE(
        names(error_about(dense, closing.taken() - 1), "join vertices that nearly coincide"));
    const TriangleSoup crossed = soup_in_a_line(random, 100);
    EXPECT_TRUE(names(error_about(crossed, steps_for(crossed) / 2),
                      "divide triangles where vertices of others touch their edges"));
}

TEST(PreparationAllowance, EstimatesWhatDividingNeeds) {
    std::mt19937_64 random(1);
    for (int round = 0; round < 3; ++round) {
        const TriangleSoup soup = soup_in_a_line(random, 200);
        const auto needed = static_cast<double>(steps_for(soup));
        const std::string error = error_about(soup, 2'000'000);
        const std::string before = "needs about ";
        const double said = 1e6 * std::stod(error.substr(error.find(before) + before.size()));
        EXPECT_GT(said, 0.8 * needed) << error;
        EXPECT_LT(said, 1.25 * needed) << error;
    }
}

/// Beyond an allowance go the portions of the threads, and the last item that each looked at.
std::uint64_t max_beyond(const TriangleSoup &soup, unsigned threads) {
    return threads * ((1 << 20) + (kStepsPerPiece + kStepsPerNode) * soup.vertices_m.size());
}

TEST(PreparationAllowance, BoundsTheWorkForAnySoup) {
    using Make = std::function<TriangleSoup(std::mt19937_64 &, int)>;
    std::mt19937_64 random(1);
    constexpr std::uint64_t kAllowed = 5'000'000;
    int refused = 0;
    for (const auto &[make, size] : std::vector<std::pair<Make, int>>{
             {soup_in_a_line, 3000}, {cloud, 3000}, {stack, 20}, {fan, 3000}, {book, 3000}}) {
        for (const int share : {1, 10, 100}) {
            for (const unsigned threads : {1U, 2U}) {
                const TriangleSoup soup = make(random, std::max(2, size / share));
                PreparationAllowance allowance(soup.triangles.size(), kAllowed);
                const std::string error =
                    error_text_of([&] { run_stages(soup, allowance, threads); });
                refused += error.empty() ? 0 : 1;
                EXPECT_EQ(error.empty(), allowance.taken() <= kAllowed) << error;
                EXPECT_LE(allowance.taken(), kAllowed + max_beyond(soup, threads));
            }
        }
    }
    EXPECT_GT(refused, 0);
}

TEST(PreparationAllowance, IsHardlyTouchedByFansAndBooksHoweverMany) {
    std::mt19937_64 random(1);
    for (const int triangles : {1000, 10'000}) {
        EXPECT_LT(steps_for(fan(random, triangles)), kAllowedSteps / 10);
        EXPECT_LT(steps_for(book(random, triangles)), kAllowedSteps / 10);
    }
}

} // namespace
} // namespace springdrive::contact
