// Covers engine/contact/mesh/fan_grading.cpp and triangle_fans.cpp.
#include "engine/contact/mesh/fan_grading.h"

#include "base/cancellation.h"
#include "tests/engine/contact/mesh/meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>

namespace springdrive::contact {
namespace {

using testing::area_m2;
using testing::Corners;

/// A surface around a vertex, r(φ) (cos φ, h(φ), sin φ) at its rim, turned and moved at random.
struct RimShape {
    double radius_m = 5e-3;
    double jagged = 0.0; ///< by which part of it r may be smaller
    double slope = 0.0;  ///< of h, the same everywhere
    double wave = 0.0;   ///< of h, twice around
    double rough = 0.0;  ///< of h, at random
    double turn = 2.0 * std::numbers::pi;
};

struct Given {
    std::vector<MeshTriangle> triangles;
    std::vector<FacetSource> facets;
    std::size_t vertices = 0;
    Vector3 apex_m{Vector3::Zero()};
};

Given fan_of(std::uint32_t count, const RimShape &shape, std::mt19937_64 &random) {
    std::uniform_real_distribution<double> part(0.0, 1.0);
    const Matrix3 turn =
        Eigen::AngleAxisd(6.0 * part(random), testing::random_vector(random, 1.0).normalized())
            .toRotationMatrix();
    const Vector3 apex_m = testing::random_vector(random, 0.1);
    const bool is_closed = shape.turn > 6.0;
    std::vector<Vector3> rim_m;
    for (std::uint32_t i = 0; i < count + (is_closed ? 0 : 1); ++i) {
        const double phi = shape.turn * i / count;
        const double out_m = shape.radius_m * (1.0 - shape.jagged * part(random));
        const double height =
            shape.slope + shape.wave * std::cos(2.0 * phi) + shape.rough * part(random);
        rim_m.emplace_back(apex_m + out_m * (turn * Vector3(std::cos(phi), height, std::sin(phi))));
    }
    Given given;
    given.apex_m = apex_m;
    given.vertices = rim_m.size() + 1;
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto next = static_cast<std::uint32_t>((i + 1) % rim_m.size());
        // Each begins at another of its corners.
        VertexTriple vertices = {0, 1 + next, 1 + i};
        Corners corners_m = {apex_m, rim_m[next], rim_m[i]};
        std::rotate(vertices.begin(), vertices.begin() + i % 3, vertices.end());
        std::rotate(corners_m.begin(), corners_m.begin() + i % 3, corners_m.end());
        given.triangles.push_back({vertices, i});
        given.facets.push_back({corners_m, FacetSides::two, i});
    }
    return given;
}

double nearest_m(const Vector3 &point_m, const std::vector<FacetSource> &facets) {
    double min_m = INFINITY;
    for (const FacetSource &facet : facets) {
        min_m = std::min(min_m, testing::distance_to_triangle(facet.corners_m, point_m));
    }
    return min_m;
}

Vector3 middle_m(const FacetSource &facet) {
    return (facet.corners_m[0] + facet.corners_m[1] + facet.corners_m[2]) / 3.0;
}

/// From a point of one of the facets to the nearest of others.
double distance_m(const FacetSource &facet, const std::vector<FacetSource> &others,
                  std::mt19937_64 &random) {
    std::uniform_real_distribution<double> part(0.0, 1.0);
    Vector3 weights(part(random), part(random), part(random));
    weights = weights.array().pow(3.0); // often near a corner or an edge
    weights /= weights.sum();
    const Vector3 point_m = weights[0] * facet.corners_m[0] + weights[1] * facet.corners_m[1] +
                            weights[2] * facet.corners_m[2];
    return nearest_m(point_m, others);
}

std::size_t count_at(const Vector3 &point_m, const std::vector<FacetSource> &facets) {
    return static_cast<std::size_t>(std::ranges::count_if(facets, [&](const FacetSource &facet) {
        return std::ranges::find(facet.corners_m, point_m) != facet.corners_m.end();
    }));
}

/// Each edge as often in one direction as it is used, less how often in the other.
using EdgeBalance = std::map<std::array<double, 6>, int>;

EdgeBalance edge_balance(const std::vector<FacetSource> &facets) {
    EdgeBalance balance;
    const auto key = [](const Vector3 &a, const Vector3 &b) {
        return std::array{a.x(), a.y(), a.z(), b.x(), b.y(), b.z()};
    };
    for (const FacetSource &facet : facets) {
        for (std::size_t i = 0; i < 3; ++i) {
            const Vector3 &from = facet.corners_m[i];
            const Vector3 &to = facet.corners_m[(i + 1) % 3];
            ++balance[key(from, to)];
            --balance[key(to, from)];
        }
    }
    std::erase_if(balance, [](const auto &edge) { return edge.second == 0; });
    return balance;
}

const std::vector<RimShape> kSmooth = {
    {.jagged = 0.5}, // flat, as of a cap with any outline
    {.slope = 0.3},  // as of a pole
    {.slope = -2.0}, {.wave = 0.2}, {.slope = 0.1, .turn = 2.5}, {.radius_m = 1e-4, .slope = 0.5},
};

TEST(FanGrading, KeepsWhereSmoothFansAreWithFewTrianglesAtTheVertex) {
    std::mt19937_64 random(1);
    for (const RimShape &shape : kSmooth) {
        for (const std::uint32_t count : {100U, 333U, 1500U}) {
            Given given = fan_of(count, shape, random);
            const std::vector<FacetSource> before = given.facets;
            const GradedFans graded = grade_fans(given.facets, given.triangles, {}, given.vertices);
            ASSERT_EQ(graded.all, 1U) << shape.slope << " " << count;
            EXPECT_LE(graded.coarse, count >= kMinGradedFan ? 1U : 0U)
                << shape.slope << " " << count;
            EXPECT_LE(count_at(given.apex_m, given.facets), std::min(52U, (count + 1) / 2))
                << shape.slope << " " << count;
            EXPECT_LE(given.facets.size(), 9 * count);
            // Round-off of points within 0.2 m.
            const double allowed_m =
                (graded.coarse == 0 ? kGradingError_m : kCoarseGradingError_m) + 1e-15;
            for (int i = 0; i < 40; ++i) {
                ASSERT_LE(distance_m(before[random() % before.size()], given.facets, random),
                          allowed_m);
                ASSERT_LE(distance_m(given.facets[random() % given.facets.size()], before, random),
                          allowed_m);
            }
        }
    }
}

/// What is left of its edges, without those that two triangles share, is that of the given fan.
TEST(FanGrading, LeavesNoGaps) {
    std::mt19937_64 random(2);
    for (const RimShape &shape : kSmooth) {
        if (shape.turn < 6.0) {
            continue; // its first and last spoke are divided
        }
        for (const std::uint32_t count : {97U, 128U, 1024U}) {
            Given given = fan_of(count, shape, random);
            const EdgeBalance before = edge_balance(given.facets);
            const double area_before_m2 = area_m2(given.facets);
            ASSERT_EQ(grade_fans(given.facets, given.triangles, {}, given.vertices).all, 1U);
            EXPECT_EQ(edge_balance(given.facets), before);
            EXPECT_NEAR(area_m2(given.facets), area_before_m2, 1e-3 * area_before_m2);
        }
    }
}

TEST(FanGrading, NamesTheTriangleBelow) {
    std::mt19937_64 random(3);
    Given given = fan_of(200, {.slope = 0.2}, random);
    const std::vector<FacetSource> before = given.facets;
    ASSERT_EQ(grade_fans(given.facets, given.triangles, {}, given.vertices).all, 1U);
    for (const FacetSource &facet : given.facets) {
        const double distance =
            testing::distance_to_triangle(before[facet.triangle].corners_m, middle_m(facet));
        // Next to it, where it lies on several.
        EXPECT_LT(distance, 0.3 * (middle_m(facet) - given.apex_m).norm());
    }
}

/// So rough that no two of its triangles may become one: that changes only what is within a
/// micrometre of its vertex.
TEST(FanGrading, MakesRoughFansCoarseAtTheirVertexOnly) {
    std::mt19937_64 random(8);
    for (const RimShape &shape : {RimShape{.rough = 0.2}, RimShape{.jagged = 0.5, .rough = 1.0},
                                  RimShape{.radius_m = 1e-4, .rough = 0.2}}) {
        for (const std::uint32_t count : {49U, 300U, 1024U}) {
            Given given = fan_of(count, shape, random);
            const std::vector<FacetSource> before = given.facets;
            const EdgeBalance edges_before = edge_balance(given.facets);
            const GradedFans graded = grade_fans(given.facets, given.triangles, {}, given.vertices);
            ASSERT_EQ(graded.all, 1U);
            EXPECT_EQ(graded.coarse, 1U);
            EXPECT_EQ(edge_balance(given.facets), edges_before);
            EXPECT_LE(count_at(given.apex_m, given.facets), 12U);
            std::size_t changed = 0;
            for (const FacetSource &facet : given.facets) {
                const bool is_near =
                    std::ranges::all_of(facet.corners_m, [&](const Vector3 &corner_m) {
                        return (corner_m - given.apex_m).norm() <= 0.5 * kCoarseGradingError_m;
                    });
                changed += is_near ? 1 : 0;
                if (!is_near && changed % 10 == 0) {
                    // In the plane of a given one, but for round-off of corners within 0.2 m.
                    ASSERT_LE(nearest_m(middle_m(facet), before), 1e-15);
                }
            }
            EXPECT_GT(changed, 12U);
        }
    }
}

TEST(FanGrading, LeavesSmallFans) {
    std::mt19937_64 random(4);
    Given small = fan_of(static_cast<std::uint32_t>(kMinGradedFan - 1), {}, random);
    EXPECT_EQ(grade_fans(small.facets, small.triangles, {}, small.vertices).all, 0U);
    EXPECT_TRUE(std::ranges::none_of(small.facets, &FacetSource::is_crowded));
}

/// A third triangle stands on one of the spokes. It belongs to another, larger fan, which has its
/// own vertex; the spoke stays, so that nothing passes below it.
TEST(FanGrading, KeepsASpokeOnWhichAThirdTriangleStands) {
    std::mt19937_64 random(9);
    Given given = fan_of(2001, {.slope = -0.3}, random);
    const std::size_t own = given.facets.size();
    const std::uint32_t foot = 1 + 751; // at the rim, and dissolved without the third triangle
    const Vector3 foot_m = given.facets[751].corners_m[1]; // begins at its second
    const Vector3 spoke_m = foot_m - given.apex_m;
    const auto top = static_cast<std::uint32_t>(given.vertices++);
    const Vector3 top_m = given.apex_m + spoke_m + 5e-3 * spoke_m.unitOrthogonal();
    const auto add = [&](const VertexTriple &vertices, const Corners &corners_m) {
        given.triangles.push_back({vertices, static_cast<std::uint32_t>(given.facets.size())});
        given.facets.push_back(
            {corners_m, FacetSides::two, static_cast<std::uint32_t>(given.facets.size())});
    };
    add({0, foot, top}, {given.apex_m, foot_m, top_m});
    Vector3 last_m = top_m + Vector3(1e-3, 0.0, 0.0);
    for (std::uint32_t i = 0; i < 2100; ++i) { // the larger fan
        const double phi = 2.0 * std::numbers::pi * (i + 1) / 2100;
        const Vector3 next_m = top_m + 1e-3 * Vector3(std::cos(phi), std::sin(phi), 0.0);
        const auto first = static_cast<std::uint32_t>(given.vertices++);
        add({top, first, first + 1}, {top_m, last_m, next_m});
        last_m = next_m;
    }
    ++given.vertices;
    ASSERT_LT(testing::distance_to_triangle(given.facets[750].corners_m, foot_m), 1e-15);
    EXPECT_GE(grade_fans(given.facets, given.triangles, {}, given.vertices).all, 2U);
    std::erase_if(given.facets, [&](const FacetSource &facet) { return facet.triangle >= own; });
    for (double share = 0.001; share < 1.0; share *= 1.3) {
        // Round-off of corners within 0.2 m.
        EXPECT_LE(nearest_m(given.apex_m + share * spoke_m, given.facets), 1e-15) << share;
    }
}

TEST(FanGrading, KeepsMaterialsApart) {
    std::mt19937_64 random(5);
    Given given = fan_of(200, {}, random);
    for (std::size_t i = 0; i < 100; ++i) {
        given.facets[i].material = 1;
    }
    EXPECT_EQ(grade_fans(given.facets, given.triangles, {}, given.vertices).all, 2U);
    std::array<std::vector<FacetSource>, 2> of_material;
    for (const FacetSource &facet : given.facets) {
        of_material[facet.material].push_back(facet);
    }
    EXPECT_NEAR(area_m2(of_material[0]), area_m2(of_material[1]), 1e-9 * area_m2(of_material[0]));
}

/// As CAD systems divide a round face: from a vertex of its outline, so that the first and the last
/// triangles are small.
TEST(FanGrading, GradesAFanFromAVertexOfItsOutline) {
    constexpr std::uint32_t kCount = 3000;
    constexpr double kRadius_m = 5e-3;
    Given given;
    const auto rim_m = [&](std::uint32_t i) {
        const double phi = 2.0 * std::numbers::pi * i / (kCount + 2);
        return Vector3(kRadius_m * std::cos(phi), 0.02, kRadius_m * std::sin(phi));
    };
    given.apex_m = rim_m(0);
    given.vertices = kCount + 2;
    for (std::uint32_t i = 0; i < kCount; ++i) {
        given.triangles.push_back({{0, i + 2, i + 1}, i});
        given.facets.push_back({{given.apex_m, rim_m(i + 2), rim_m(i + 1)}, FacetSides::one, i});
    }
    const double area_before_m2 = area_m2(given.facets);
    const std::vector<FacetSource> before = given.facets;
    EXPECT_EQ(grade_fans(given.facets, given.triangles, {}, given.vertices).all, 1U);
    EXPECT_LE(count_at(given.apex_m, given.facets), 250U);
    EXPECT_NEAR(area_m2(given.facets), area_before_m2, 1e-9 * area_before_m2);
    std::mt19937_64 random(7);
    for (int i = 0; i < 100; ++i) {
        ASSERT_LE(distance_m(before[random() % before.size()], given.facets, random), 1e-15);
    }
}

/// One fan alone may take seconds.
TEST(FanGrading, CanBeGivenUpWithinAFan) {
    std::mt19937_64 random(8);
    const Given given = fan_of(300, {.rough = 0.04}, random);
    auto by_vertex = find_fan_triangles(given.triangles, {}, given.vertices, kMinGradedFan);
    ASSERT_EQ(by_vertex.size(), 1U);
    const std::vector<TriangleFan> fans = fans_of(by_vertex[0], given.facets);
    ASSERT_EQ(fans.size(), 1U);
    EXPECT_FALSE(rings_of(fans[0]).triangles.empty());
    const std::atomic<bool> is_cancelled{true};
    const StopScope by(&is_cancelled);
    EXPECT_THROW(static_cast<void>(rings_of(fans[0])), Cancelled);
    EXPECT_THROW(static_cast<void>(fans_of(by_vertex[0], given.facets)), Cancelled);
}

/// A triangle that was left out does not shift those that follow.
TEST(FanGrading, AllowsForTrianglesLeftOut) {
    std::mt19937_64 random(6);
    Given given = fan_of(120, {}, random);
    given.facets.erase(given.facets.begin() + 7);
    const double area_before_m2 = area_m2(given.facets);
    const EdgeBalance before = edge_balance(given.facets);
    EXPECT_EQ(grade_fans(given.facets, given.triangles, {7}, given.vertices).all, 1U);
    EXPECT_NEAR(area_m2(given.facets), area_before_m2, 1e-9 * area_before_m2);
    for (const auto &[edge, uses] : before) {
        const Vector3 from(edge[0], edge[1], edge[2]);
        const Vector3 to(edge[3], edge[4], edge[5]);
        if (from != given.apex_m && to != given.apex_m) {
            EXPECT_TRUE(edge_balance(given.facets).contains(edge));
        }
    }
}

} // namespace
} // namespace springdrive::contact
