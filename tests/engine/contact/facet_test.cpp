// Covers engine/contact/facet.cpp.
#include "engine/contact/facet.h"

#include "tests/engine/contact/soups.h"

#include <gtest/gtest.h>

namespace springdrive {
namespace {

// In the plane z = 0, facing +z.
const testing::Corners kTriangle = {Vector3(0, 0, 0), Vector3(0.02, 0, 0), Vector3(0, 0.01, 0)};

Facet facet(FacetSides sides, const testing::Corners &triangle = kTriangle) {
    return Facet({triangle, sides, 7});
}

/// How much of a motion by 40 mm straight through the facet is allowed.
double allowed(double height_m) { return (height_m - kClearance_m) / 0.04; }

Vector3 above(double x, double y, double z = 0.01) { return {x, y, z}; }
Vector3 below(double x, double y) { return {x, y, -0.03}; }

TEST(Facet, FacesTheSideFromWhichItIsWoundCounterClockwise) {
    EXPECT_EQ(facet(FacetSides::one).normal(), Vector3::UnitZ());
    EXPECT_EQ(facet(FacetSides::one).height_m({5, 5, 0.25}), 0.25);
    EXPECT_EQ(facet(FacetSides::one).triangle(), 7U);
}

TEST(Facet, OfOneSideStopsWhatComesFromTheFrontOnly) {
    const Facet one = facet(FacetSides::one);
    EXPECT_NEAR(one.stop(above(0.001, 0.001), below(0.001, 0.001)).value_or(-1), allowed(0.01),
                1e-12);
    EXPECT_FALSE(one.stop(below(0.001, 0.001), above(0.001, 0.001)));
}

TEST(Facet, OfTwoSidesStopsWhatComesFromEither) {
    const Facet two = facet(FacetSides::two);
    EXPECT_NEAR(two.stop(above(0.001, 0.001), below(0.001, 0.001)).value_or(-1), allowed(0.01),
                1e-12);
    EXPECT_NEAR(two.stop(below(0.001, 0.001), above(0.001, 0.001)).value_or(-1), allowed(0.03),
                1e-12);
}

TEST(Facet, IgnoresMotionsThatStayOnOneSide) {
    for (const FacetSides sides : {FacetSides::one, FacetSides::two}) {
        EXPECT_FALSE(
            facet(sides).stop(above(0.001, 0.001), above(0.001, 0.001, 1.01 * kClearance_m)));
        EXPECT_FALSE(facet(sides).stop(above(0.001, 0.001), above(0.002, 0.001)));
        EXPECT_FALSE(facet(sides).stop(below(0.001, 0.001), below(0.001, 0.001)));
    }
}

TEST(Facet, StopsWhatHasSunkInByRoundOff) {
    const Facet one = facet(FacetSides::one);
    EXPECT_EQ(one.stop(above(0.001, 0.001, -0.9 * kRoundOff_m), below(0.001, 0.001)), 0.0);
    EXPECT_FALSE(one.stop(above(0.001, 0.001, -1.1 * kRoundOff_m), below(0.001, 0.001)));
}

TEST(Facet, StopsWhatWouldComeTooNear) {
    for (const FacetSides sides : {FacetSides::one, FacetSides::two}) {
        const Vector3 from = above(0.001, 0.001, 2.0 * kClearance_m);
        const std::optional<double> allowed =
            facet(sides).stop(from, above(0.001, 0.001, 0.5 * kClearance_m));
        EXPECT_NEAR(allowed.value_or(-1), 2.0 / 3.0, 1e-12);
    }
}

TEST(Facet, StopsWhatIsTooNearAndComesNearerHoweverSlowly) {
    for (const FacetSides sides : {FacetSides::one, FacetSides::two}) {
        // Down from the clearance by steps of a picometre and a bit: none may get through.
        double height_m = kClearance_m;
        while (!facet(sides).stop(above(0.001, 0.001, height_m),
                                  above(0.001, 0.001, height_m - 1.1e-12))) {
            height_m -= 1.1e-12;
            ASSERT_GT(height_m, 0.0);
        }
        // And by less than that, from where nearly nothing is left.
        EXPECT_EQ(facet(sides).stop(above(0.001, 0.001, 0.5e-9), above(0.001, 0.001, 0.49999e-9)),
                  0.0);
    }
}

TEST(Facet, LetsWhatIsTooNearMoveAlongAndAway) {
    const Facet one = facet(FacetSides::one);
    EXPECT_FALSE(one.stop(above(0.001, 0.001, 0.5e-7), above(0.002, 0.001, 0.5e-7)));
    EXPECT_FALSE(one.stop(above(0.001, 0.001, 0.5e-7), above(0.002, 0.001, 0.6e-7)));
}

TEST(Facet, HasARimOfConstantWidth) {
    const Facet one = facet(FacetSides::one);
    const auto is_crossed_at = [&](double x, double y) {
        return one.stop(above(x, y), below(x, y)).has_value();
    };
    constexpr double kInside = 0.99 * kRim_m;
    constexpr double kOutside = 1.01 * kRim_m;
    EXPECT_TRUE(is_crossed_at(0.01, -kInside));
    EXPECT_FALSE(is_crossed_at(0.01, -kOutside));
    EXPECT_TRUE(is_crossed_at(-kInside, 0.005));
    EXPECT_FALSE(is_crossed_at(-kOutside, 0.005));
    EXPECT_TRUE(is_crossed_at(0.02 + kInside, 0.0));
    EXPECT_FALSE(is_crossed_at(0.02 + kOutside, 0.0));
}

TEST(Facet, HasNoSpikeAtASharpCorner) {
    // One micrometre high and 20 mm long: straight rims would meet 2 mm beyond the tip.
    const testing::Corners needle = {Vector3(0, 0, 0), Vector3(0.02, 0, 0), Vector3(0.02, 1e-6, 0)};
    const Facet one = facet(FacetSides::one, needle);
    EXPECT_TRUE(one.stop(above(-0.9 * kRim_m, 0.0), below(-0.9 * kRim_m, 0.0)));
    EXPECT_FALSE(one.stop(above(-2.0 * kRim_m, 0.0), below(-2.0 * kRim_m, 0.0)));
}

TEST(Facet, AgreesWithBarycentricCoordinates) {
    std::mt19937_64 random(1);
    int crossings = 0;
    for (int i = 0; i < 100000; ++i) {
        const testing::Corners triangle = {testing::random_vector(random, 0.1),
                                           testing::random_vector(random, 0.1),
                                           testing::random_vector(random, 0.1)};
        const Vector3 from = testing::random_vector(random, 0.1);
        const Vector3 to = testing::random_vector(random, 0.1);
        // The motion's crossing with the plane, by Cramer's rule.
        Matrix3 system;
        system << triangle[1] - triangle[0], triangle[2] - triangle[0], from - to;
        const Vector3 uvt = system.inverse() * (from - triangle[0]);
        const double margin =
            std::min({uvt[0], uvt[1], 1.0 - uvt[0] - uvt[1], uvt[2], 1.0 - uvt[2]});
        if (std::abs(margin) < 1e-4) {
            continue; // on the rim or so oblique that the oracle itself is unsure
        }
        const Facet two = facet(FacetSides::two, triangle);
        const std::optional<double> allowed = two.stop(from, to);
        ASSERT_EQ(allowed.has_value(), margin > 0.0);
        if (allowed) {
            ++crossings;
            const double slope = std::abs(two.normal().dot(to - from));
            ASSERT_NEAR(*allowed, uvt[2] - kClearance_m / slope, 1e-9);
        }
    }
    EXPECT_GT(crossings, 1000); // not vacuous
}

TEST(Facet, KnowsHeights) {
    EXPECT_DOUBLE_EQ(smallest_height_m(kTriangle), 0.0002 / std::hypot(0.02, 0.01));
    EXPECT_EQ(smallest_height_m({Vector3::Zero(), Vector3::Zero(), Vector3::Zero()}), 0.0);
    EXPECT_EQ(smallest_height_m({Vector3::Zero(), Vector3::UnitX(), 2 * Vector3::UnitX()}), 0.0);
}

} // namespace
} // namespace springdrive
