// Covers engine/contact/proxy/resting_contact.cpp.
#include "engine/contact/proxy/resting_contact.h"

#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

namespace springdrive::contact {
namespace {

/// Of places within 0.1 m, a few roundings.
constexpr double kRestRounding_m = 1e-15;

/// A slab with its upper side at y = 0, and a ball half sunk into it, of another material.
HapticSurface slab_and_ball() {
    TriangleSoup soup = testing::box_soup({-0.1, -0.05, -0.1}, {0.1, 0.0, 0.1}, 0.5);
    soup.materials.push_back({"ball", 0.25});
    return HapticSurface(soup, {AnalyticShape(Sphere{0.02}, Eigen::Isometry3d::Identity(), 1)});
}

std::uint32_t ball_of(const HapticSurface &surface) {
    return static_cast<std::uint32_t>(surface.report().triangles_given);
}

TEST(RestingContact, IsFreeWithoutPlanes) {
    const Contact contact = free_contact({0.1, 0.2, 0.3});
    EXPECT_FALSE(contact.touching);
    EXPECT_EQ(contact.x0_m, Vector3(0.1, 0.2, 0.3));
    EXPECT_EQ(contact.tangent_projector, Matrix3::Identity());
    EXPECT_EQ(contact.eta, 1.0);
    EXPECT_TRUE(contact.settled);
}

TEST(RestingContact, BetweenTwoObstaclesHasOneFreeDirectionAndTheStifferMaterial) {
    const HapticSurface surface = slab_and_ball();
    const double floor_m = kClearance_m;
    Rest rest;
    rest.point_m = {0.02 + kClearance_m, floor_m, 0.0};
    rest.held_by.add({Vector3::UnitX(), rest.point_m.x(), ball_of(surface)});
    rest.held_by.add({Vector3::UnitY(), floor_m, 0});
    const Contact contact = resting_contact(surface, {0.017, -0.004, 0.0}, rest);
    EXPECT_TRUE(contact.touching);
    EXPECT_EQ(contact.active_constraints, 2);
    EXPECT_LT((contact.tangent_projector - Vector3::UnitZ() * Vector3::UnitZ().transpose()).norm(),
              kRestRounding_m);
    EXPECT_EQ(contact.eta, 0.25);
    EXPECT_LT((contact.normal - Vector3(0.6, 0.8, 0.0)).norm(), 1e-5); // 3-4-5, but for 10 nm
    EXPECT_EQ(contact.material, 1);
    EXPECT_EQ(contact.triangle, ball_of(surface));
    EXPECT_NEAR(contact.surface_m.norm(), 0.02, kRestRounding_m);
}

TEST(RestingContact, AfterASlideMatchesThatOfThePlane) {
    const HapticSurface surface = slab_and_ball();
    for (const double reach_m : {kClearance_m, 1e-3}) {
        const Vector3 up = Vector3(1.0, 2.0, 2.0) / 3.0;
        const Vector3 tip_m = 0.018 * up;
        ShapeSlide slide;
        slide.normal = up;
        slide.rest_m = slide.over_m = (0.02 + reach_m) * up;
        slide.depth_m = 0.002;
        Rest rest{slide.rest_m, {}};
        rest.held_by.add({up, 0.02 + reach_m, ball_of(surface)});
        const Contact expected = resting_contact(surface, tip_m, rest);
        const Contact contact = resting_contact(surface, ball_of(surface), slide, reach_m);
        EXPECT_TRUE(contact.touching);
        EXPECT_TRUE(contact.settled);
        EXPECT_FALSE(contact.sticking);
        EXPECT_EQ(contact.x0_m, expected.x0_m);
        EXPECT_LT((contact.tangent_projector - expected.tangent_projector).norm(), kRestRounding_m);
        // The way of 2 mm between places rounded to 1e-17 m.
        EXPECT_LT((contact.normal - expected.normal).norm(), 1e-13);
        EXPECT_EQ(contact.eta, expected.eta);
        EXPECT_EQ(contact.active_constraints, expected.active_constraints);
        EXPECT_LT((contact.surface_m - expected.surface_m).norm(), kRestRounding_m);
        EXPECT_EQ(contact.barycentric, expected.barycentric);
        EXPECT_EQ(contact.triangle, expected.triangle);
        EXPECT_EQ(contact.material, expected.material);
    }
}

} // namespace
} // namespace springdrive::contact
