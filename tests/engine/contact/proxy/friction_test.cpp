// Covers engine/contact/proxy/friction.cpp, and friction in engine/contact/proxy/proxy.cpp:
// Coulomb's law.
#include "engine/contact/proxy/friction.h"

#include "base/degrees.h"
#include "engine/contact/proxy/proxy.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace springdrive::contact {
namespace {

HapticSurface floor_with(double static_friction, double dynamic_friction) {
    TriangleSoup soup = testing::box_soup({-0.1, -0.02, -0.1}, {0.1, 0.0, 0.1});
    soup.materials[0].static_friction = static_friction;
    soup.materials[0].dynamic_friction = dynamic_friction;
    return HapticSurface(soup);
}

/// Between the force and the floor's normal [rad].
double angle(const Contact &contact) {
    return std::atan2(std::hypot(contact.normal.x(), contact.normal.z()), contact.normal.y());
}

/// A proxy pressed straight into the floor at x.
Proxy pressed(const HapticSurface &floor, double x_m, double depth_m) {
    Proxy proxy;
    proxy.reset({x_m, 0.01, 0.0});
    static_cast<void>(proxy.update(floor, {x_m, -depth_m, 0.0}));
    return proxy;
}

TEST(Friction, SlipsAtTheAngleOfTheStaticAndSlidesAtThatOfTheDynamicCoefficient) {
    std::mt19937_64 random(1);
    for (int i = 0; i < 40; ++i) {
        const double mu_s = 0.05 + 0.05 * (i % 20);
        const double mu_d = 0.7 * mu_s;
        const HapticSurface floor = floor_with(mu_s, mu_d);
        const double depth_m = 1e-3 + 1e-4 * static_cast<double>(random() % 30);
        const double heading = 0.1 * static_cast<double>(random() % 60);
        Proxy proxy = pressed(floor, 0.0, depth_m);
        double slipped_at = 0.0;
        double sliding_at = 0.0;
        // Steps of 2 µm: at a depth of a millimetre a tenth of a degree.
        for (int step = 1; step < 4000; ++step) {
            const double way_m = 2e-6 * step;
            const Contact contact = proxy.update(
                floor, {way_m * std::cos(heading), -depth_m, way_m * std::sin(heading)});
            ASSERT_TRUE(contact.touching);
            if (contact.sticking) {
                ASSERT_EQ(contact.tangent_projector, Matrix3::Zero());
                slipped_at = angle(contact);
            } else {
                sliding_at = angle(contact);
                ASSERT_EQ(contact.active_constraints, 1);
            }
        }
        EXPECT_NEAR(slipped_at, std::atan(mu_s), 0.2 * kRadiansPerDegree);
        EXPECT_NEAR(sliding_at, std::atan(mu_d), 0.01 * kRadiansPerDegree);
    }
}

TEST(Friction, DoesNotCreepWhileItSticks) {
    // For a minute at 1 kHz, the tip trembling within the cone of friction.
    const HapticSurface floor = floor_with(0.4, 0.3);
    Proxy proxy = pressed(floor, 0.01, 2e-3);
    const Vector3 held = proxy.update(floor, {0.01, -2e-3, 0.0}).x0_m;
    for (int tick = 0; tick < 60000; ++tick) {
        const double t = 1e-3 * tick;
        const Vector3 vibration(0.7e-3 * std::sin(9.0 * t), 1e-4 * std::sin(50.0 * t),
                                1e-4 * t / 60.0);
        const Contact contact = proxy.update(floor, Vector3(0.01, -2e-3, 0.0) + vibration);
        ASSERT_TRUE(contact.sticking);
        ASSERT_EQ(contact.x0_m, held) << "tick " << tick;
    }
}

TEST(Friction, SlipsRightOutsideOfItsConeAndNotRightInside) {
    const HapticSurface floor = floor_with(0.5, 0.5);
    for (const double share : {0.99999, 1.00001}) {
        Proxy proxy = pressed(floor, 0.0, 1e-3);
        const Contact contact =
            proxy.update(floor, {0.0, -1e-3, share * 0.5 * (1e-3 + kClearance_m)});
        EXPECT_EQ(contact.sticking, share < 1.0);
    }
}

TEST(Friction, IsAbsentWithZeroCoefficients) {
    const HapticSurface smooth = floor_with(0.0, 0.0);
    Proxy proxy = pressed(smooth, 0.0, 1e-3);
    const Contact contact = proxy.update(smooth, {0.013, -1e-3, 0.004});
    EXPECT_FALSE(contact.sticking);
    EXPECT_LT(angle(contact), 1e-9);
}

TEST(Friction, ReleasesWhereTheTipLeaves) {
    const HapticSurface floor = floor_with(0.8, 0.8);
    Proxy proxy = pressed(floor, 0.0, 1e-3);
    const Vector3 above(0.0, 1e-3, 0.0);
    const Contact contact = proxy.update(floor, above);
    EXPECT_FALSE(contact.touching);
    EXPECT_EQ(contact.x0_m, above);
}

TEST(Friction, TakesMoreWorkThanItGivesBackOnAnyClosedPath) {
    // The hand's work on the spring between tip and proxy, over closed paths: never negative.
    std::mt19937_64 random(2);
    for (int path = 0; path < 30; ++path) {
        const HapticSurface floor = floor_with(0.1 * (path % 9), 0.07 * (path % 9));
        Proxy proxy;
        const double a = 1.0 + 0.1 * static_cast<double>(random() % 10);
        const auto tip_at = [&](double s) {
            const double t = 2.0 * std::numbers::pi * s;
            return Vector3(0.02 * std::sin(t), 2e-3 - 6e-3 * std::sin(0.5 * t) * std::sin(0.5 * t),
                           0.01 * std::sin(2.0 * t) * a);
        };
        Vector3 tip = tip_at(0.0);
        proxy.reset(tip);
        double work = 0.0; // over the stiffness [m²]
        constexpr int kSteps = 5000;
        for (int i = 1; i <= kSteps; ++i) {
            const Contact contact = proxy.update(floor, tip);
            const Vector3 next = tip_at(static_cast<double>(i) / kSteps);
            // The proxy stays over the step, so the spring's energy is exact at both its ends.
            work += 0.5 *
                    ((contact.x0_m - next).squaredNorm() - (contact.x0_m - tip).squaredNorm()) *
                    (contact.touching ? 1.0 : 0.0);
            tip = next;
        }
        EXPECT_GT(work, -1e-12);
    }
}

} // namespace
} // namespace springdrive::contact
