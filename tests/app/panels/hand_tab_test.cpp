#include "app/panels/panels.h"
#include "engine/session/telemetry_history.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace springdrive::app {
namespace {

/// Ticks of a contact under a wall of this stiffness, pressed to `depth_m` and back.
session::TelemetryHistory pressed(double stiffness_N_per_m, double depth_m, double noise_N) {
    session::TelemetryHistory history(testing::phantom_1_0().geometry, 1000.0);
    std::mt19937_64 random(5);
    std::normal_distribution<> noise(0.0, 1.0);
    const Vector3 normal = Vector3(0.3, 0.9, -0.2).normalized();
    for (int tick = 0; tick < 1000; ++tick) {
        servo::ServoSample sample;
        sample.time_s = 1e-3 * tick;
        const double depth = depth_m * std::sin(3.14 * tick / 1000.0);
        sample.contact.touching = tick > 100; // before: free, however large the force
        sample.contact.normal = normal;
        sample.contact.x0_m = depth * normal;
        // A force across the normal must not count.
        const Vector3 across = normal.cross(Vector3::UnitX());
        sample.tip_force_N = (stiffness_N_per_m * depth + 0.2 + noise_N * noise(random)) * normal +
                             3.0 * std::sin(0.1 * tick) * across;
        history.add(sample);
    }
    return history;
}

TEST(MeasuredStiffness, IsTheSlopeOfTheForceAlongTheNormal) {
    for (const double stiffness : {50.0, 1300.0, 9000.0}) {
        const auto history = pressed(stiffness, 0.004, 0.0);
        const StiffnessMeasured found = measured_stiffness(history.store(), 0.0, 1.0);
        EXPECT_NEAR(found.slope_N_per_m, stiffness, 1e-6 * stiffness);
        EXPECT_LT(found.deviation_N_per_m, 1e-3 * stiffness);
    }
}

TEST(MeasuredStiffness, ItsDeviationIsThatOfItsErrors) {
    const auto history = pressed(1300.0, 0.004, 0.1);
    const StiffnessMeasured found = measured_stiffness(history.store(), 0.0, 1.0);
    EXPECT_NEAR(found.slope_N_per_m, 1300.0, 4.0 * found.deviation_N_per_m);
    // σ/√Σ(x − x̄)², of some 900 ticks whose depths spread by 1.2 mm.
    EXPECT_NEAR(found.deviation_N_per_m, 0.1 / (std::sqrt(900.0) * 0.0012), 1.0);
}

TEST(MeasuredStiffness, NeedsAChangeOfDepth) {
    const auto still = pressed(1300.0, 2e-5, 0.0);
    EXPECT_TRUE(std::isnan(measured_stiffness(still.store(), 0.0, 1.0).slope_N_per_m));
    const auto history = pressed(1300.0, 0.004, 0.0);
    EXPECT_TRUE(std::isnan(measured_stiffness(history.store(), 0.0, 0.09).slope_N_per_m)); // free
    EXPECT_TRUE(std::isnan(measured_stiffness(history.store(), 5.0, 6.0).slope_N_per_m));
}

} // namespace
} // namespace springdrive::app
