// Covers engine/contact/proxy/contact_planes.cpp, and neighbourhood.cpp with the neighbourhoods of
// haptic_surface.cpp.
#include "engine/contact/proxy/contact_planes.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/contact/proxy/neighbourhood.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/support/surfaces.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>

namespace springdrive::contact {
namespace {

using testing::random_direction;
using testing::random_vector;

const Vector3 kUnitY = Vector3::UnitY();

ContactPlanes planes(std::initializer_list<ContactPlane> list) {
    ContactPlanes result;
    for (const ContactPlane &plane : list) {
        result.add(plane);
    }
    return result;
}

/// The conditions of a nearest point: it is allowed, it is on every active plane, and its offset
/// from the tip is a positive sum of their normals.
void expect_optimal(const Vector3 &tip, const ContactPlanes &all, const NearestPoint &nearest) {
    // Round-off of 1e-17 m over the smallest sine between random normals, about 1e-4.
    constexpr double kTolerance_m = 1e-12;
    for (const ContactPlane &plane : all) {
        ASSERT_GT(plane.height_m(nearest.point_m), -kTolerance_m);
    }
    Eigen::Matrix<double, 3, Eigen::Dynamic> normals(3, nearest.active.size());
    for (std::size_t i = 0; i < nearest.active.size(); ++i) {
        normals.col(static_cast<Eigen::Index>(i)) = nearest.active[i].normal;
        ASSERT_NEAR(nearest.active[i].height_m(nearest.point_m), 0.0, kTolerance_m);
    }
    const Vector3 gap = nearest.point_m - tip;
    if (nearest.active.size() == 0) {
        ASSERT_EQ(gap, Vector3::Zero());
        return;
    }
    const Eigen::VectorXd pushes = normals.fullPivLu().solve(gap);
    ASSERT_LT((normals * pushes - gap).norm(), kTolerance_m);
    ASSERT_GT(pushes.minCoeff(), 0.0);
}

TEST(NearestPoint, MeetsTheConditionsOfAnOptimum) {
    std::mt19937_64 random(1);
    std::array<int, 4> seen{};
    for (int i = 0; i < 50000; ++i) {
        const Vector3 tip = random_vector(random, 0.01);
        const Vector3 inside = random_vector(random, 0.01);
        ContactPlanes all;
        const std::size_t count = 1 + static_cast<std::size_t>(i) % 4;
        while (all.size() < count) {
            const Vector3 normal = random_direction(random);
            // Below `inside`, so that there is a solution; mostly above the tip.
            const double below = normal.dot(inside) - 1e-4;
            all.add({normal, std::min(below, normal.dot(tip) + 5e-3), 0});
        }
        const NearestPoint nearest = nearest_point(tip, all, inside);
        expect_optimal(tip, all, nearest);
        if (HasFatalFailure()) {
            FAIL() << "in case " << i;
        }
        ++seen[nearest.active.size()];
    }
    EXPECT_GT(*std::ranges::min_element(seen), 100); // not vacuous
}

TEST(NearestPoint, IsAccurateBetweenPlanesThatAreNearlyParallel) {
    // Valleys of ever smaller angles; their bottom is the line x = y = 0.
    for (const double angle : {1e-1, 1e-3, 1e-5}) {
        const Vector3 left(std::sin(angle), std::cos(angle), 0.0);
        const Vector3 right(-std::sin(angle), std::cos(angle), 0.0);
        const NearestPoint nearest = nearest_point(
            {0.0, -0.01, 0.02}, planes({{left, 0.0, 1}, {right, 0.0, 2}}), {0.0, 0.01, 0.0});
        // Round-off of the data, 1e-18 m, grows by one over the angle.
        EXPECT_LT((nearest.point_m - Vector3(0.0, 0.0, 0.02)).norm(), 1e-16 / angle);
    }
}

TEST(NearestPoint, TakesTheUpperOfTwoParallelPlanes) {
    const NearestPoint nearest = nearest_point(
        {0.0, -0.01, 0.0}, planes({{kUnitY, 0.001, 1}, {kUnitY, 0.002, 2}, {kUnitY, 0.0015, 3}}),
        kUnitY);
    EXPECT_LT((nearest.point_m - Vector3(0.0, 0.002, 0.0)).norm(), 1e-15);
    ASSERT_EQ(nearest.active.size(), 1U);
    EXPECT_EQ(nearest.active[0].obstacle, 2U);
}

TEST(NearestPoint, LowersPlanesThatLeaveNoRoom) {
    // A gap of 1 nm between planes that each require 100 nm.
    const ContactPlanes gap = planes({{kUnitY, 1e-7, 1}, {-kUnitY, 1e-7 - 1e-9, 2}});
    const Vector3 inside(0.0, 0.5e-9, 0.0);
    const NearestPoint nearest = nearest_point({0.01, -0.01, 0.0}, gap, inside);
    EXPECT_LT((nearest.point_m - Vector3(0.01, 0.5e-9, 0.0)).norm(), 1e-12);
    ASSERT_EQ(nearest.active.size(), 1U);
    EXPECT_EQ(nearest.active[0].obstacle, 1U);
}

void expect_projector(const Matrix3 &P, int rank) {
    EXPECT_LT((P - P.transpose()).norm(), 1e-15);
    EXPECT_LT((P * P - P).norm(), 1e-14);
    EXPECT_NEAR(P.trace(), rank, 1e-14);
}

TEST(AllowedMotion, LeavesThePlaneOfAFaceTheLineOfAnEdgeAndNothingAtAVertex) {
    std::mt19937_64 random(2);
    for (int i = 0; i < 1000; ++i) {
        const Vector3 a = random_direction(random);
        const Vector3 b = random_direction(random);
        const Vector3 c = random_direction(random);
        const Vector3 t = a.cross(b).normalized();

        const AllowedMotion face = tangent_projector(planes({{a, 0.0, 0}}));
        EXPECT_LT((face.projector - (Matrix3::Identity() - a * a.transpose())).norm(), 1e-14);
        EXPECT_EQ(face.blocked_directions, 1);
        expect_projector(face.projector, 2);

        const AllowedMotion edge = tangent_projector(planes({{a, 0.0, 0}, {b, 0.0, 0}}));
        // Oracle and result both lose digits as the planes become parallel.
        EXPECT_LT((edge.projector - t * t.transpose()).norm(), 1e-14 / a.cross(b).norm());
        EXPECT_EQ(edge.blocked_directions, 2);

        const AllowedMotion vertex = tangent_projector(planes({{a, 0, 0}, {b, 0, 0}, {c, 0, 0}}));
        EXPECT_EQ(vertex.projector, Matrix3::Zero());
        EXPECT_EQ(vertex.blocked_directions, 3);
    }
}

TEST(AllowedMotion, CountsNearlyParallelPlanesAsOne) {
    const auto tilted = [](double angle) { return Vector3(std::sin(angle), std::cos(angle), 0.0); };
    const AllowedMotion one =
        tangent_projector(planes({{kUnitY, 0.0, 0}, {tilted(0.9e-6), 0.0, 0}}));
    EXPECT_EQ(one.blocked_directions, 1);
    const AllowedMotion two =
        tangent_projector(planes({{kUnitY, 0.0, 0}, {tilted(1.1e-6), 0.0, 0}}));
    EXPECT_EQ(two.blocked_directions, 2);
}

using testing::random_vector;

Neighbourhood around(const HapticSurface &surface, const Vector3 &centre_m, double radius_m) {
    SearchBudget budget{1'000'000};
    Neighbourhood near;
    surface.find_near(centre_m, radius_m, budget, near);
    return near;
}

TEST(Neighbourhood, MissesNothingThatStopsAMotionWithinIt) {
    std::mt19937_64 random(1);
    int stopped = 0;
    for (int mesh = 0; mesh < 40; ++mesh) {
        const TriangleSoup soup = testing::random_soup(random, 300, 0.04, 0.01);
        const HapticSurface surface(soup);
        for (int i = 0; i < 50; ++i) {
            const Neighbourhood near = around(surface, random_vector(random, 0.04), 0.02);
            ASSERT_GT(near.radius_m(), 0.0);
            ASSERT_LE(near.radius_m(), 0.02);
            ASSERT_LE(near.size(), Neighbourhood::kCapacity);
            const double inner_m = (near.radius_m() - kClearance_m) / std::sqrt(3.0);
            const Vector3 from = near.centre_m() + random_vector(random, inner_m);
            const Vector3 to = near.centre_m() + random_vector(random, inner_m);
            ASSERT_TRUE(near.covers(from, kClearance_m));
            SearchBudget budget{1'000'000};
            const auto expected = surface.first_stop(from, to, kClearance_m, budget);
            const auto found = surface.first_stop(near, from, to, kClearance_m, budget);
            ASSERT_EQ(expected.has_value(), found.has_value());
            if (expected) {
                ++stopped;
                ASSERT_EQ(expected->stop.fraction, found->stop.fraction);
                ASSERT_EQ(expected->obstacle, found->obstacle);
            }
        }
    }
    EXPECT_GT(stopped, 100); // not vacuous
}

TEST(Neighbourhood, ReportsWhetherATipIsLessDeepBehindAnyOfItsFacets) {
    std::mt19937_64 random(2);
    int shallower = 0;
    for (int i = 0; i < 200; ++i) {
        const TriangleSoup soup = testing::random_soup(random, 10, 0.02, 0.02);
        const HapticSurface surface(soup);
        const Neighbourhood near = around(surface, Vector3::Zero(), 0.1);
        const Vector3 tip = random_vector(random, 0.02);
        double min_m = 1.0;
        for (std::uint32_t index = 0; index < soup.triangles.size(); ++index) {
            const Facet &facet = surface.facet(index);
            const double height_m = facet.height_m(tip);
            const bool is_behind = facet.sides() == FacetSides::two || height_m <= 0.0;
            min_m = is_behind ? std::min(min_m, std::abs(height_m)) : min_m;
        }
        EXPECT_TRUE(near.has_shallower(tip, min_m + 1e-9));
        EXPECT_FALSE(near.has_shallower(tip, min_m - 1e-9));
        EXPECT_FALSE(near.has_only(0));
        shallower += near.size() > 0 ? 1 : 0;
    }
    EXPECT_EQ(shallower, 200);
}

TEST(Neighbourhood, ReportsWhenItHoldsOnlyShapes) {
    TriangleSoup soup;
    soup.materials = {{"shapes", 0.0}};
    Eigen::Isometry3d aside = Eigen::Isometry3d::Identity();
    aside.translate(Vector3(0.05, 0.0, 0.0));
    const HapticSurface surface(soup,
                                {AnalyticShape(Sphere{0.01}, Eigen::Isometry3d::Identity(), 0),
                                 AnalyticShape(Sphere{0.01}, aside, 0)});
    EXPECT_TRUE(around(surface, {-0.02, 0.0, 0.0}, 0.005).has_only(0b00));
    EXPECT_TRUE(around(surface, {-0.02, 0.0, 0.0}, 0.02).has_only(0b01));
    EXPECT_TRUE(around(surface, {0.07, 0.0, 0.0}, 0.02).has_only(0b10));
    EXPECT_TRUE(around(surface, {0.025, 0.0, 0.0}, 0.02).has_only(0b11));
    EXPECT_FALSE(around(surface, {0.025, 0.0, 0.0}, 0.02).has_only(0b01));
}

TEST(Neighbourhood, CoversNothingWhereMoreMeetThanItCanHold) {
    // A fan of a hundred triangles about one point.
    TriangleSoup fan;
    for (int i = 0; i < 100; ++i) {
        const auto rim = [](int k) {
            const double angle = 0.0628 * k;
            return Vector3(0.01 * std::cos(angle), 0.002 * (k % 2), 0.01 * std::sin(angle));
        };
        testing::add_triangle(fan, {Vector3::Zero(), rim(i), rim(i + 1)});
    }
    const HapticSurface surface(fan);
    EXPECT_FALSE(around(surface, Vector3::Zero(), 1e-3).covers(Vector3::Zero(), 0.0));
    EXPECT_TRUE(around(surface, Vector3(0, 0.005, 0), 1e-3).covers(Vector3(0, 0.005, 0), 0.9e-3));
}

TEST(Neighbourhood, ReportsHowFarAMotionStaysWithin) {
    const HapticSurface surface(testing::icosphere(2, 0.05));
    const Neighbourhood near = around(surface, Vector3(0.1, 0.0, 0.0), 0.01);
    EXPECT_EQ(near.size(), 0);
    const Vector3 from(0.095, 0.0, 0.0);
    EXPECT_NEAR(near.covered_fraction(from, {0.125, 0.0, 0.0}, 1e-3), (0.109 - 0.095) / 0.03,
                1e-12);
    EXPECT_EQ(near.covered_fraction(from, {0.1, 0.008, 0.0}, 1e-3), 1.0);
    EXPECT_FALSE(near.covers({0.1, 0.0095, 0.0}, 1e-3));
}

} // namespace
} // namespace springdrive::contact
