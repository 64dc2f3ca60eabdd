// Covers engine/contact/mesh/facet.cpp.
#include "engine/contact/mesh/facet.h"
#include "engine/contact/proxy/contact_planes.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/support/surfaces.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>

namespace springdrive::contact {
namespace {

using testing::Corners;
using testing::random_vector;

TEST(NearestOnTriangle, IsNearerThanAnySampleAndOnTheTriangle) {
    std::mt19937_64 random(1);
    for (int i = 0; i < 2000; ++i) {
        const testing::Corners triangle = {random_vector(random, 1.0), random_vector(random, 1.0),
                                           random_vector(random, 1.0)};
        const Vector3 query = random_vector(random, 2.0);
        const TrianglePoint nearest = nearest_on_triangle(triangle, query);
        const Vector3 &w = nearest.weights;
        ASSERT_GE(w.minCoeff(), 0.0);
        ASSERT_NEAR(w.sum(), 1.0, 1e-14);
        const Vector3 by_weights = w[0] * triangle[0] + w[1] * triangle[1] + w[2] * triangle[2];
        ASSERT_LT((by_weights - nearest.point_m).norm(), 1e-11);
        const double distance = (query - nearest.point_m).norm();
        ASSERT_NEAR(distance, testing::distance_to_triangle(triangle, query), 1e-11);
        for (int u = 0; u <= 12; ++u) {
            for (int v = 0; u + v <= 12; ++v) {
                const Vector3 sample = triangle[0] + u / 12.0 * (triangle[1] - triangle[0]) +
                                       v / 12.0 * (triangle[2] - triangle[0]);
                ASSERT_LE(distance, (query - sample).norm() + 1e-14);
            }
        }
    }
}

TEST(SegmentDistance, IsTheMinimumOverAllPairsOfPoints) {
    std::mt19937_64 random(2);
    for (int i = 0; i < 3000; ++i) {
        const Vector3 a = random_vector(random, 1.0);
        const Vector3 c = random_vector(random, 1.0);
        // Also parallel ones, and points.
        const Vector3 b = i % 7 == 0 ? a : Vector3(a + random_vector(random, 1.0));
        const Vector3 d = i % 5 == 0    ? Vector3(c + 0.7 * (b - a))
                          : i % 11 == 0 ? c
                                        : Vector3(c + random_vector(random, 1.0));
        double minimum = INFINITY;
        constexpr int kSamples = 40;
        for (int u = 0; u <= kSamples; ++u) {
            const Vector3 p = a + u * (b - a) / kSamples;
            minimum = std::min(minimum, (d - c).norm() > 0.0 ? testing::distance_to_segment(p, c, d)
                                                             : (p - c).norm());
        }
        const double distance = segment_distance_m(a, b, c, d);
        ASSERT_LE(distance, minimum + 1e-12);
        // Half a sample's step along a–b, at most.
        ASSERT_GE(distance, minimum - 0.5 * (b - a).norm() / kSamples - 1e-12);
    }
}

TEST(SegmentDistance, IsRightFarBelowTheLengthOfTheSegments) {
    // Two that cross, 1e-8 apart: distances that a proxy keeps.
    const double distance = segment_distance_m({-0.1, 0.0, 0.3}, {0.1, 0.0, 0.3},
                                               {0.02, -0.1, 0.3 + 1e-8}, {0.01, 0.1, 0.3 + 1e-8});
    EXPECT_NEAR(distance, 1e-8, 1e-16);
}

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

TEST(Facet, StopsMotionsFromItsSides) {
    const Vector3 up = above(0.001, 0.001);
    const Vector3 down = below(0.001, 0.001);
    for (const FacetSides sides : {FacetSides::one, FacetSides::two}) {
        const Facet any = facet(sides);
        EXPECT_NEAR(fraction(any, up, down), allowed(0.01), 1e-12);
        EXPECT_EQ(fraction(any, up, above(0.001, 0.001, 1.01 * kClearance_m)), -1); // stays above
        EXPECT_EQ(fraction(any, up, above(0.002, 0.001)), -1);
        EXPECT_EQ(fraction(any, down, down), -1);
    }
    EXPECT_EQ(fraction(facet(FacetSides::one), down, up), -1);
    EXPECT_NEAR(fraction(facet(FacetSides::two), down, up), allowed(0.03), 1e-12);
    EXPECT_EQ(stop_of(facet(FacetSides::two), down, up, kClearance_m)->normal, -Vector3::UnitZ());
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

/// Without effort a motion may end early, never late, and then says that it does not know.
TEST(Facet, MissesOnlyStopsBeyondTheFractionOfInterestAndWithoutEffortStopsNoLater) {
    std::mt19937_64 random(2);
    int missed = 0;
    int found = 0;
    int unknown = 0;
    for (int i = 0; i < 20000; ++i) {
        const Facet two =
            facet(FacetSides::two, {random_vector(random, 0.01), random_vector(random, 0.01),
                                    random_vector(random, 0.01)});
        const Vector3 from = random_vector(random, 0.01);
        const Vector3 to = random_vector(random, 0.01);
        const std::optional<Stop> expected = stop_of(two, from, to, 1e-3);
        int no_effort = 0;
        const std::optional<Stop> early = two.stop(from, to, 1e-3, 1.0, no_effort);
        ASSERT_LT(no_effort, 0);
        ASSERT_GE(no_effort, -kFacetEffort);
        if (early && early->normal.isZero(0.0)) {
            ++unknown;
            ASSERT_LE(early->fraction, expected ? expected->fraction : 1.0);
        } else {
            ASSERT_EQ(early.has_value(), expected.has_value());
        }
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

FacetSource random_facet(std::mt19937_64 &random, double size_m, double width_m) {
    FacetSource facet;
    facet.corners_m[0] = random_vector(random, 0.1);
    facet.corners_m[1] = facet.corners_m[0] + random_vector(random, size_m);
    facet.corners_m[2] = facet.corners_m[1] + random_vector(random, width_m);
    return facet;
}

TEST(FacetBoxes, CoverTheirFacets) {
    std::mt19937_64 random(1);
    std::vector<FacetSource> facets;
    for (int i = 0; i < 300; ++i) {
        facets.push_back(random_facet(random, 0.02, i % 3 == 0 ? 0.02 : 1e-5));
        facets.back().is_crowded = i % 2 == 0;
    }
    const FacetBoxes found = boxes_of(facets);
    ASSERT_EQ(found.boxes_m.size(), found.facet_of_box.size());
    EXPECT_GT(found.boxes_m.size(), 2 * facets.size());
    std::vector<std::vector<Eigen::AlignedBox3d>> boxes_of_facet(facets.size());
    for (std::size_t i = 0; i < found.boxes_m.size(); ++i) {
        boxes_of_facet[found.facet_of_box[i]].push_back(found.boxes_m[i]);
    }
    std::uniform_real_distribution<double> part(0.0, 1.0);
    for (std::size_t i = 0; i < facets.size(); ++i) {
        const auto &[a, b, c] = facets[i].corners_m;
        for (int sample = 0; sample < 300; ++sample) {
            const double along = sample % 10 == 0 ? 1.0 : part(random);
            const double across = sample % 7 == 0 ? 0.0 : part(random);
            const Vector3 point_m = a + along * (b - a + across * (c - b));
            // Round-off of the point itself.
            ASSERT_TRUE(std::ranges::any_of(boxes_of_facet[i], [&](const auto &box) {
                return box.exteriorDistance(point_m) < 1e-16;
            })) << i;
        }
    }
}

TEST(FacetBoxes, AreOneForEachThatFillsItsOwn) {
    const TriangleSoup sphere = testing::icosphere(4, 0.05);
    std::vector<FacetSource> facets;
    for (std::size_t i = 0; i < sphere.triangles.size(); ++i) {
        facets.push_back({testing::corners(sphere, i)});
    }
    const FacetBoxes found = boxes_of(facets);
    ASSERT_EQ(found.boxes_m.size(), facets.size());
    for (std::uint32_t i = 0; i < facets.size(); ++i) {
        EXPECT_EQ(found.facet_of_box[i], i);
        Eigen::AlignedBox3d box;
        for (const Vector3 &corner_m : facets[i].corners_m) {
            box.extend(corner_m);
        }
        EXPECT_TRUE(found.boxes_m[i].isApprox(box, 0.0));
    }
}

/// Of a long thin facet that lies across the axes, what its boxes hold that is not near it.
TEST(FacetBoxes, OfAnObliqueNeedleHoldLittleElse) {
    FacetSource needle;
    needle.corners_m = {Vector3(0, 0, 0), Vector3(0.02, 0.02, 0.02), Vector3(0.02, 0.02, 0.02001)};
    const FacetBoxes found = boxes_of({needle});
    double volume_m3 = 0.0;
    for (const Eigen::AlignedBox3d &box : found.boxes_m) {
        volume_m3 += box.volume();
    }
    EXPECT_GT(found.boxes_m.size(), 50U);
    EXPECT_LT(found.boxes_m.size(), 2000U);
    EXPECT_LT(volume_m3, 1e-3 * 8e-6);
}

using testing::random_direction;

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
