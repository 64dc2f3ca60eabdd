// Covers engine/contact/mesh/facet.cpp.
#include "engine/contact/mesh/facet.h"

#include "tests/engine/contact/mesh/soups.h"

#include <gtest/gtest.h>

#include <cmath>

namespace springdrive::contact {
namespace {

using testing::Corners;
using testing::random_vector;

// In the plane z = 0, facing +z.
const Corners kTriangle = {Vector3(0, 0, 0), Vector3(0.02, 0, 0), Vector3(0, 0.01, 0)};

Facet facet(FacetSides sides, const Corners &triangle = kTriangle) {
    return Facet({triangle, sides, 7});
}

Vector3 above(double x, double y, double z = 0.01) { return {x, y, z}; }
Vector3 below(double x, double y) { return {x, y, -0.03}; }

/// Where a motion by 40 mm straight down through the facet has to end.
double allowed(double height_m, double reach_m = kClearance_m) {
    return (height_m - reach_m) / 0.04;
}

/// With as much effort as it takes.
std::optional<Stop> stop_of(const Facet &facet, const Vector3 &from, const Vector3 &to,
                            double reach_m) {
    int effort_left = 1'000'000;
    return facet.stop(from, to, reach_m, 1.0, effort_left);
}

/// Fraction of a motion that is allowed; -1 where all of it is.
double fraction(const Facet &facet, const Vector3 &from, const Vector3 &to,
                double reach_m = kClearance_m) {
    const std::optional<Stop> stop = stop_of(facet, from, to, reach_m);
    return stop ? stop->fraction : -1.0;
}

TEST(Facet, FacesTheSideFromWhichItIsWoundCounterClockwise) {
    EXPECT_EQ(facet(FacetSides::one).normal(), Vector3::UnitZ());
    EXPECT_EQ(facet(FacetSides::one).height_m({5, 5, 0.25}), 0.25);
    EXPECT_EQ(facet(FacetSides::one).triangle(), 7U);
}

TEST(Facet, WithOneSideStopsMotionsFromTheFrontOnly) {
    const Facet one = facet(FacetSides::one);
    EXPECT_NEAR(fraction(one, above(0.001, 0.001), below(0.001, 0.001)), allowed(0.01), 1e-12);
    EXPECT_FALSE(stop_of(one, below(0.001, 0.001), above(0.001, 0.001), kClearance_m));
}

TEST(Facet, WithTwoSidesStopsMotionsFromEither) {
    const Facet two = facet(FacetSides::two);
    EXPECT_NEAR(fraction(two, above(0.001, 0.001), below(0.001, 0.001)), allowed(0.01), 1e-12);
    EXPECT_NEAR(fraction(two, below(0.001, 0.001), above(0.001, 0.001)), allowed(0.03), 1e-12);
    EXPECT_EQ(stop_of(two, below(0.001, 0.001), above(0.001, 0.001), kClearance_m)->normal,
              -Vector3::UnitZ());
}

TEST(Facet, IgnoresMotionsThatStayOnOneSide) {
    for (const FacetSides sides : {FacetSides::one, FacetSides::two}) {
        const Facet any = facet(sides);
        EXPECT_EQ(fraction(any, above(0.001, 0.001), above(0.001, 0.001, 1.01 * kClearance_m)), -1);
        EXPECT_EQ(fraction(any, above(0.001, 0.001), above(0.002, 0.001)), -1);
        EXPECT_EQ(fraction(any, below(0.001, 0.001), below(0.001, 0.001)), -1);
    }
}

TEST(Facet, StopsWhatIsTooNearAndComesNearerHoweverSlowly) {
    for (const FacetSides sides : {FacetSides::one, FacetSides::two}) {
        // By half of the slack at a time: together they may use up the slack, and no more.
        double height_m = kClearance_m;
        while (!stop_of(facet(sides), above(0.001, 0.001, height_m),
                        above(0.001, 0.001, height_m - 0.5 * kSlack_m), kClearance_m)) {
            height_m -= 0.5 * kSlack_m;
            ASSERT_GT(height_m, kClearance_m - 1.1 * kSlack_m);
        }
        EXPECT_EQ(
            fraction(facet(sides), above(0.001, 0.001, 0.5e-9), above(0.001, 0.001, 0.49999e-9)),
            0.0);
    }
}

TEST(Facet, LetsWhatIsTooNearMoveAlongAndAway) {
    const Facet one = facet(FacetSides::one);
    EXPECT_EQ(fraction(one, above(0.001, 0.001, 0.5e-8), above(0.002, 0.001, 0.5e-8)), -1);
    EXPECT_EQ(fraction(one, above(0.001, 0.001, 0.5e-8), above(0.002, 0.001, 0.6e-8)), -1);
}

TEST(Facet, KeepsWhatStartsTooNearAtItsOwnDistance) {
    const Facet one = facet(FacetSides::one);
    const auto offset = [&](double height_m) {
        return stop_of(one, above(0.001, 0.001, height_m), below(0.001, 0.001), kClearance_m)
            ->offset_m;
    };
    EXPECT_DOUBLE_EQ(offset(0.5 * kClearance_m), 0.5 * kClearance_m);
    EXPECT_DOUBLE_EQ(offset(kClearance_m - 0.9 * kLostByRoundOff_m), kClearance_m);
    EXPECT_DOUBLE_EQ(offset(kClearance_m - 1.1 * kLostByRoundOff_m),
                     kClearance_m - 1.1 * kLostByRoundOff_m);
}

TEST(Facet, ReachesPastItsEdgesByTheReachAndNoMore) {
    for (const double reach_m : {kClearance_m, 0.5e-3}) {
        const Facet one = facet(FacetSides::one);
        const auto is_crossed_at = [&](double x, double y) {
            return stop_of(one, above(x, y), below(x, y), reach_m).has_value();
        };
        EXPECT_TRUE(is_crossed_at(0.01, -0.999 * reach_m));
        EXPECT_FALSE(is_crossed_at(0.01, -1.001 * reach_m));
        EXPECT_TRUE(is_crossed_at(-0.999 * reach_m, 0.005));
        EXPECT_FALSE(is_crossed_at(-1.001 * reach_m, 0.005));
        EXPECT_TRUE(is_crossed_at(0.02 + 0.999 * reach_m, 0.0));
        EXPECT_FALSE(is_crossed_at(0.02 + 1.001 * reach_m, 0.0));
    }
}

TEST(Facet, LetsPassWhatSlidesOverItsEdgeOnANeighboursPlane) {
    // A sheet that bends down at the edge y = 0: what comes over it on the level grazes the round
    // edge, a clearance above.
    for (const double bend : {0.0, 1e-6, 1e-3, 0.3, 1.5, 3.0}) {
        const Corners bent = {Vector3(0, 0, 0), Vector3(0.02, 0, 0),
                              Vector3(0.01, 0.01 * std::cos(bend), -0.01 * std::sin(bend))};
        for (const FacetSides sides : {FacetSides::one, FacetSides::two}) {
            EXPECT_EQ(fraction(facet(sides, bent), above(0.009, -0.001, kClearance_m),
                               above(0.012, 0.001, kClearance_m)),
                      -1);
        }
    }
}

TEST(Facet, MissesOnlyStopsBeyondTheFractionOfInterest) {
    std::mt19937_64 random(2);
    int missed = 0;
    int found = 0;
    for (int i = 0; i < 20000; ++i) {
        const Facet two =
            facet(FacetSides::two, {random_vector(random, 0.01), random_vector(random, 0.01),
                                    random_vector(random, 0.01)});
        const Vector3 from = random_vector(random, 0.01);
        const Vector3 to = random_vector(random, 0.01);
        const std::optional<Stop> expected = stop_of(two, from, to, 1e-3);
        if (!expected) {
            continue;
        }
        int effort_left = 1'000'000;
        const double last = i % 2 == 0 ? expected->fraction : 0.999 * expected->fraction;
        const std::optional<Stop> stop = two.stop(from, to, 1e-3, last, effort_left);
        if (i % 2 == 0) {
            ASSERT_TRUE(stop);
        }
        if (stop) {
            ++found;
            ASSERT_EQ(stop->fraction, expected->fraction);
            ASSERT_EQ(stop->normal, expected->normal);
        } else {
            ++missed;
        }
    }
    EXPECT_GT(found, 1000);
    EXPECT_GT(missed, 1000); // or it would save nothing
}

/// Without effort a motion may end early, never late, and then says that it does not know.
TEST(Facet, WithoutEffortStopsNoLater) {
    std::mt19937_64 random(3);
    int unknown = 0;
    for (int i = 0; i < 20000; ++i) {
        const Facet two =
            facet(FacetSides::two, {random_vector(random, 0.01), random_vector(random, 0.01),
                                    random_vector(random, 0.01)});
        const Vector3 from = random_vector(random, 0.01);
        const Vector3 to = random_vector(random, 0.01);
        const std::optional<Stop> expected = stop_of(two, from, to, 1e-3);
        int effort_left = 0;
        const std::optional<Stop> stop = two.stop(from, to, 1e-3, 1.0, effort_left);
        ASSERT_LT(effort_left, 0);
        ASSERT_GE(effort_left, -kFacetEffort);
        if (stop && stop->normal.isZero(0.0)) {
            ++unknown;
            ASSERT_LE(stop->fraction, expected ? expected->fraction : 1.0);
        } else {
            ASSERT_EQ(stop.has_value(), expected.has_value());
        }
    }
    EXPECT_GT(unknown, 100);
}

/// The smallest distance of a motion from a triangle between two fractions, by brute force.
double min_distance(const Corners &triangle, const Vector3 &from, const Vector3 &to, double first,
                    double last) {
    double minimum = INFINITY;
    for (int i = 0; i <= 400; ++i) {
        const double s = first + (last - first) * i / 400.0;
        minimum =
            std::min(minimum, testing::distance_to_triangle(triangle, from + s * (to - from)));
    }
    return minimum;
}

TEST(Facet, StopsEveryMotionWhereItFirstComesWithinReach) {
    std::mt19937_64 random(1);
    int stopped = 0;
    for (int i = 0; i < 20000; ++i) {
        const Corners triangle = {random_vector(random, 0.01), random_vector(random, 0.01),
                                  random_vector(random, 0.01)};
        const Vector3 from = random_vector(random, 0.01);
        const Vector3 to = random_vector(random, 0.01);
        const double reach_m = i % 2 == 0 ? 1e-3 : 1e-4;
        if (testing::distance_to_triangle(triangle, from) < reach_m) {
            continue;
        }
        const Facet two = facet(FacetSides::two, triangle);
        const std::optional<Stop> stop = stop_of(two, from, to, reach_m);
        // 400 samples of 20 mm miss the lowest point by 25 µm at most, and its distance by less
        // than 25² µm² / 2 reach.
        const double unsure_m = 25e-6 * 25e-6 / reach_m;
        const double last = stop ? stop->fraction : 1.0;
        ASSERT_GT(min_distance(triangle, from, to, 0.0, last), reach_m - 1e-11);
        if (!stop) {
            continue;
        }
        ++stopped;
        const Vector3 at = from + stop->fraction * (to - from);
        ASSERT_NEAR(testing::distance_to_triangle(triangle, at), reach_m, 1e-11);
        // From there on it would come nearer, and the plane has the triangle behind it.
        ASSERT_LT(min_distance(triangle, at, to, 0.0, 1.0), reach_m + unsure_m);
        ASSERT_NEAR(stop->normal.norm(), 1.0, 1e-14);
        ASSERT_NEAR(stop->normal.dot(at), stop->offset_m, 1e-11);
        ASSERT_LT(stop->normal.dot(to), stop->offset_m);
        for (const Vector3 &corner : triangle) {
            ASSERT_LT(stop->normal.dot(corner), stop->offset_m - reach_m + 1e-9);
        }
    }
    EXPECT_GT(stopped, 2000); // not vacuous
}

TEST(Facet, TouchesWhatIsAtItsReach) {
    std::mt19937_64 random(2);
    for (int i = 0; i < 20000; ++i) {
        const Corners triangle = {random_vector(random, 0.01), random_vector(random, 0.01),
                                  random_vector(random, 0.01)};
        const Facet two = facet(FacetSides::two, triangle);
        const Vector3 place = random_vector(random, 0.01);
        const double distance_m = testing::distance_to_triangle(triangle, place);
        EXPECT_FALSE(two.touch(place, distance_m - 1e-6, 0.9e-6));
        const std::optional<Stop> touch = two.touch(place, distance_m - 1e-6, 1.1e-6);
        ASSERT_TRUE(touch);
        ASSERT_NEAR(touch->normal.dot(place) - touch->offset_m, 1e-6, 1e-12);
    }
}

TEST(Facet, ReportsHeightsAboveItsPlane) {
    EXPECT_DOUBLE_EQ(min_height_m(kTriangle), 0.0002 / std::hypot(0.02, 0.01));
    EXPECT_EQ(min_height_m({Vector3::Zero(), Vector3::Zero(), Vector3::Zero()}), 0.0);
    EXPECT_EQ(min_height_m({Vector3::Zero(), Vector3::UnitX(), 2 * Vector3::UnitX()}), 0.0);
}

} // namespace
} // namespace springdrive::contact
