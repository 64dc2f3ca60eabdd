// Covers engine/contact/proxy/neighbourhood.cpp and the neighbourhoods of
// engine/contact/proxy/haptic_surface.cpp.
#include "engine/contact/proxy/neighbourhood.h"

#include "engine/contact/proxy/haptic_surface.h"
#include "tests/engine/contact/mesh/soups.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>

namespace springdrive::contact {
namespace {

using testing::random_vector;

Neighbourhood around(const HapticSurface &surface, const Vector3 &centre_m, double radius_m) {
    SearchBudget budget{1'000'000};
    Neighbourhood near;
    surface.find_near(centre_m, radius_m, budget, near);
    return near;
}

/// Triangles that the neighbourhood lists, found by a motion through every plane.
std::set<std::uint32_t> triangles_stopping(const HapticSurface &surface, const Neighbourhood &near,
                                           const Vector3 &from, const Vector3 &to) {
    std::set<std::uint32_t> found;
    near.for_each_in_the_way(from, to, kClearance_m, [&](std::uint32_t index) {
        found.insert(surface.facet(index).triangle());
    });
    return found;
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

TEST(Neighbourhood, GetsSmallerWhereItWouldHoldTooMany) {
    const TriangleSoup soup = testing::icosphere(5, 0.05);
    const HapticSurface surface(soup);
    const Vector3 centre(0.0, 0.05, 0.0);
    const Neighbourhood near = around(surface, centre, 0.1);
    EXPECT_LE(near.size(), Neighbourhood::kCapacity);
    EXPECT_GT(near.size(), 0);
    // Everything that intersects its ball is still listed.
    std::set<std::uint32_t> expected;
    for (std::uint32_t i = 0; i < soup.triangles.size(); ++i) {
        if (testing::distance_to_triangle(testing::corners(soup, i), centre) < near.radius_m()) {
            expected.insert(i);
        }
    }
    const std::set<std::uint32_t> found =
        triangles_stopping(surface, near, {0.0, 0.06, 0.0}, {0.0, 0.04, 0.0});
    for (const std::uint32_t triangle : expected) {
        EXPECT_TRUE(found.contains(triangle)) << triangle;
    }
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
