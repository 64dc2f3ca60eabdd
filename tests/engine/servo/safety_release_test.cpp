// Covers engine/servo/safety_monitor.cpp: releasing a device.
#include "tests/engine/servo/safety_monitor_fixture.h"

#include <gtest/gtest.h>

#include <cmath>

namespace springdrive::servo {
namespace {

using testing::SafetyMonitorTest;

SafetyOrders to_release() {
    SafetyOrders orders;
    orders.release = true;
    return orders;
}

TEST_F(SafetyMonitorTest, RampsDownForASecondOnReleaseAndThenBrakes) {
    start_up();
    double before_V = pass(calm()).e_W_V.cwiseAbs().maxCoeff();
    int ticks = 0;
    for (; ticks < 1100; ++ticks) {
        const double now_V = pass(calm(), to_release()).e_W_V.cwiseAbs().maxCoeff();
        EXPECT_LE(now_V, before_V);
        EXPECT_LE(before_V - now_V, 0.3 * kPeriod_s / kRampTime_s + 1e-12); // of 0.3 V
        before_V = now_V;
        if (monitor.status().state == SafetyState::waiting) {
            break;
        }
        EXPECT_EQ(monitor.status().state, SafetyState::releasing);
        EXPECT_TRUE(monitor.lets_pass());
    }
    EXPECT_NEAR(ticks + 1, kRampTime_s / kPeriod_s, 1.0);
    expect_braking(pass(calm(), to_release()));
}

TEST_F(SafetyMonitorTest, DoesNotStartAgainWhileReleaseIsRequested) {
    for (int tick = 0; tick < 3000; ++tick) {
        pass(calm(), to_release());
        ASSERT_EQ(monitor.status().state, SafetyState::waiting);
    }
    pass(calm());
    EXPECT_EQ(monitor.status().state, SafetyState::starting);
}

TEST_F(SafetyMonitorTest, ReleasesFromThePresentRampAndReturnsFromThere) {
    for (int tick = 0; tick < 600; ++tick) { // half-way up
        pass(calm());
    }
    ASSERT_EQ(monitor.status().state, SafetyState::starting);
    const double top = monitor.status().ramp;
    for (int tick = 0; tick < 100; ++tick) {
        pass(calm(), to_release());
    }
    EXPECT_NEAR(monitor.status().ramp, top - 0.1, 1e-9);
    for (int tick = 0; tick < 100; ++tick) {
        pass(calm());
    }
    EXPECT_NEAR(monitor.status().ramp, top, 1e-9);
    EXPECT_EQ(monitor.status().state, SafetyState::starting);
}

TEST_F(SafetyMonitorTest, StillTripsDuringReleaseAndATripStays) {
    start_up();
    pass(calm(), to_release());
    SafetyOrders stop = to_release();
    stop.requested_stop = 1;
    expect_braking(pass(calm(), stop));
    EXPECT_EQ(monitor.status().cause, TripCause::emergency_stop);
    pass(calm(), to_release());
    EXPECT_EQ(monitor.status().state, SafetyState::tripped);
}

TEST_F(SafetyMonitorTest, WithoutAZeroItBrakesAtOnceAndWaits) {
    start_up();
    Observation seen = calm();
    seen.link.zeroing = 0;
    expect_braking(pass(seen));
    EXPECT_EQ(monitor.status().ramp, 0.0);
    for (int tick = 0; tick < 2000; ++tick) {
        seen.now.tip_m.x() += tick % 7 == 0 ? 0.05 : -0.01; // its angles mean nothing
        expect_braking(pass(seen));
        ASSERT_EQ(monitor.status().state, SafetyState::waiting);
    }
    start_up(); // zeroed: a jump by that is none
}

TEST_F(SafetyMonitorTest, AContradictedMotorVoidsTheZero) {
    start_up();
    Observation seen = calm();
    seen.interval[1] = {.duration_s = 0.1, .after_rad = 10.0}; // it turns without a current
    const device::DeviceCommand command = pass(seen);
    expect_braking(command);
    EXPECT_TRUE(command.voids_zero);
    EXPECT_EQ(monitor.status().cause, TripCause::motor_contradicted);
}

TEST_F(SafetyMonitorTest, AZeroingWhileMotorsAreDrivenIsAJump) {
    start_up();
    Observation seen = calm();
    seen.link.zeroing = 2;
    seen.now.tip_m.x() += 0.05;
    expect_braking(pass(seen));
    EXPECT_EQ(monitor.status().cause, TripCause::encoder_jump);
}

TEST_F(SafetyMonitorTest, CountsThatNoMechanismHasVoidTheirZeroInAnyState) {
    const double give_rad = device.limits.beyond_stops_rad;
    const auto beyond_stop = [&](bool is_upper, double share) {
        const device::JointLimits &stops = device.joint_limits;
        const double q_rad =
            is_upper ? stops.max_rad[0] + share * give_rad : stops.min_rad[0] - share * give_rad;
        Observation seen = calm();
        seen.now.theta_rad = device::motor_from_joint(device.geometry, Vector3(q_rad, 0.2, 0.1));
        return seen;
    };
    SafetyOrders stopped;
    stopped.requested_stop = 1;
    for (const SafetyOrders &orders : {SafetyOrders{}, to_release(), stopped}) {
        for (const bool is_upper : {false, true}) {
            monitor = SafetyMonitor(device, kPeriod_s);
            pass(calm(), orders);
            EXPECT_FALSE(pass(beyond_stop(is_upper, 0.999), orders).voids_zero);
            EXPECT_TRUE(pass(beyond_stop(is_upper, 1.001), orders).voids_zero);
            EXPECT_FALSE(pass(calm(), orders).voids_zero);
        }
        monitor = SafetyMonitor(device, kPeriod_s);
        Observation seen = calm();
        pass(seen, orders);
        seen.now.tip_m.x() += 0.05;
        EXPECT_TRUE(pass(seen, orders).voids_zero);
        EXPECT_FALSE(pass(seen, orders).voids_zero);
    }
}

} // namespace
} // namespace springdrive::servo
