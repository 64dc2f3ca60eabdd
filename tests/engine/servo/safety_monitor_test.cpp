// Covers engine/servo/safety_monitor.cpp: start, limiting, windings, release. Trips are in
// safety_trips_test.cpp.
#include "engine/servo/safety_monitor.h"

#include "engine/control/rendered_force.h"
#include "engine/servo/command_limiter.h"
#include "tests/engine/servo/safety_monitor_fixture.h"

#include <gtest/gtest.h>

#include <cmath>

namespace springdrive::servo {
namespace {

using testing::SafetyMonitorTest;

TEST_F(SafetyMonitorTest, WaitsForATenthOfASecondAtRestThenRampsForASecond) {
    int waiting = 0;
    while (monitor.status().state == SafetyState::waiting && waiting < 1000) {
        expect_braking(pass(calm()));
        EXPECT_FALSE(monitor.lets_pass() && monitor.status().ramp > 0.0);
        ++waiting;
    }
    EXPECT_NEAR(waiting, 0.1 / kPeriod_s, 2.0);
    EXPECT_EQ(monitor.status().state, SafetyState::starting);
    int starting = 0;
    while (monitor.status().state == SafetyState::starting && starting < 2000) {
        const device::DeviceCommand command = pass(calm());
        ++starting;
        const double ramp = monitor.status().ramp;
        EXPECT_NEAR(ramp, starting * kPeriod_s / 1.0, 1e-12);
        EXPECT_LT((command.e_W_V - ramp * little().e_W_V).norm(), 1e-15);
        EXPECT_LT((command.cancelled_resistance_Ohm - Vector3::Constant(1.5 * ramp)).norm(), 1e-14);
    }
    EXPECT_NEAR(starting, 1.0 / kPeriod_s, 1.0);
    EXPECT_EQ(monitor.status().state, SafetyState::running);
    EXPECT_EQ(pass(calm()).e_W_V, little().e_W_V);
}

TEST_F(SafetyMonitorTest, RampsForASecondAtAnyRate) {
    for (const double rate_hz : {250.0, 3000.0, 10'000.0}) {
        monitor = SafetyMonitor(device, 1.0 / rate_hz);
        int ticks = 0;
        while (monitor.status().state != SafetyState::running && ticks < 20'000) {
            pass(calm());
            ++ticks;
        }
        EXPECT_NEAR(ticks, 1.1 * rate_hz, 4.0);
    }
}

TEST_F(SafetyMonitorTest, NeverStartsInContact) {
    Observation touching = calm();
    touching.touching = true;
    for (int i = 0; i < 2000; ++i) {
        expect_braking(pass(touching));
        ASSERT_EQ(monitor.status().state, SafetyState::waiting);
    }
    for (int i = 0; i < 99; ++i) { // all of the time in free space
        pass(calm());
        ASSERT_EQ(monitor.status().state, SafetyState::waiting);
    }
    pass_calm(3);
    EXPECT_EQ(monitor.status().state, SafetyState::starting);
}

TEST_F(SafetyMonitorTest, NeverStartsWhileTheTipMoves) {
    Observation moving = calm();
    for (int i = 0; i < 2000; ++i) { // 50 mm/s to and fro
        moving.now.tip_m.x() += (i / 500 % 2 == 0 ? 1.0 : -1.0) * 0.05 * kPeriod_s;
        expect_braking(pass(moving));
        ASSERT_EQ(monitor.status().state, SafetyState::waiting);
    }
    for (int i = 0; i < 102; ++i) {
        pass(moving);
    }
    EXPECT_EQ(monitor.status().state, SafetyState::starting);
}

TEST_F(SafetyMonitorTest, MayMoveAndTouchOnceStarting) {
    pass_calm(110);
    ASSERT_EQ(monitor.status().state, SafetyState::starting);
    Observation seen = calm();
    seen.touching = true;
    for (int i = 0; i < 1000; ++i) {
        seen.now.tip_m.x() += 0.02 * kPeriod_s;
        pass(seen);
    }
    EXPECT_EQ(monitor.status().state, SafetyState::running);
}

TEST_F(SafetyMonitorTest, AResetRestartsWaitAndRamp) {
    start_up();
    Observation pushed = calm();
    pushed.tip_force_N.x() = 9.0;
    pass(pushed);
    for (int i = 0; i < 1000; ++i) { // at rest for long, but tripped
        expect_braking(pass(calm()));
    }
    monitor.reset();
    EXPECT_EQ(monitor.status().state, SafetyState::waiting);
    EXPECT_EQ(monitor.status().cause, TripCause::none);
    for (int i = 0; i < 99; ++i) {
        expect_braking(pass(calm()));
        ASSERT_EQ(monitor.status().state, SafetyState::waiting);
    }
    start_up();
}

TEST_F(SafetyMonitorTest, EachPressOfTheSwitchIsAStop) {
    start_up();
    std::uint32_t presses = 0;
    for (const bool is_pressed : {true, false, true, false}) {
        Observation seen = calm();
        seen.link.faults.bits = device::BoardFaults::kStop;
        if (is_pressed) {
            seen.link.faults.bits |= device::BoardFaults::kPressed;
            ++presses;
        }
        for (int i = 0; i < 3; ++i) {
            pass(seen);
            EXPECT_EQ(monitor.status().held_stop, presses);
        }
    }
    EXPECT_FALSE(monitor.reset(1));
    EXPECT_TRUE(monitor.reset(2));
}

/// A second press could be among what nobody saw.
TEST_F(SafetyMonitorTest, AResetClearsNothingOfTheBoardOnceAReportIsMissing) {
    for (const bool is_missing : {false, true}) {
        SafetyMonitor once_more(device, kPeriod_s);
        monitor = once_more;
        start_up();
        Observation stopped = calm();
        stopped.link.faults.bits = device::BoardFaults::kStop;
        pass(stopped);
        ASSERT_EQ(monitor.status().held_stop, 1U);
        SafetyOrders orders;
        orders.released_stop = 1;
        ASSERT_TRUE(monitor.reset(1));
        EXPECT_TRUE(pass(stopped, orders).resets_faults);
        if (is_missing) {
            Link nothing = stopped.link;
            nothing.arrival = device::Arrival::absent;
            EXPECT_FALSE(monitor.hold(little(), nothing, orders).resets_faults);
        }
        for (int i = 0; i < 90; ++i) {
            EXPECT_EQ(pass(stopped, orders).resets_faults, !is_missing);
        }
        for (int i = 0; i < 20; ++i) { // it stays on
            EXPECT_EQ(pass(stopped, orders).e_W_V, Vector3::Zero());
        }
        EXPECT_EQ(monitor.status().held_stop, 2U);
        EXPECT_FALSE(monitor.reset(1));
    }
}

TEST_F(SafetyMonitorTest, AResetWithoutATripDoesNothing) {
    start_up();
    monitor.reset();
    EXPECT_EQ(monitor.status().state, SafetyState::running);
    EXPECT_EQ(pass(calm()).e_W_V, little().e_W_V);
}

TEST_F(SafetyMonitorTest, LimitsCommandsToSupplyForceAndResistance) {
    start_up();
    const device::DeviceCommand absurd{Vector3(1e3, -1e3, 0.0), Vector3(10.0, -1.0, 2.0)};
    const device::DeviceCommand command = pass(calm(), {}, absurd);
    EXPECT_TRUE(monitor.active_limits().holds_force());
    const device::MotorParameters &motor = device.motor[0];
    Vector3 steady_current_A;
    for (Eigen::Index j = 0; j < 3; ++j) {
        EXPECT_LE(std::abs(command.e_W_V[j]), motor.supply_V);
        EXPECT_GE(command.cancelled_resistance_Ohm[j], 0.0);
        EXPECT_LT(command.cancelled_resistance_Ohm[j], motor.resistance_Ohm);
        steady_current_A[j] =
            command.e_W_V[j] / ((1.0 - motor.commutation_ripple) * motor.resistance_Ohm -
                                command.cancelled_resistance_Ohm[j]);
    }
    const Vector3 k_T = Vector3::Constant(motor.torque_constant_Nm_per_A);
    EXPECT_LE(control::static_tip_force(calm().now.J, k_T, steady_current_A).norm(),
              kLimiterShare * device.limits.tip_force_N * (1.0 + 1e-9));
    // A lowered voltage, when it is tighter than force and current.
    SafetyOrders orders;
    orders.limits.voltage_V = 0.25;
    device::DeviceCommand held;
    for (int i = 0; i < 1000 && monitor.limits().voltage_V > 0.25; ++i) { // until it has ramped
                                                                          // down
        held = pass(calm(), orders);
    }
    EXPECT_EQ(held.e_W_V, Vector3(0.2, -0.25, 0.1));
    EXPECT_TRUE(monitor.active_limits().voltage);
    for (int i = 0; i < 5; ++i) { // 12 mV a tick back
        held = pass(calm());
    }
    EXPECT_EQ(held.e_W_V, little().e_W_V);
    EXPECT_FALSE(monitor.active_limits().voltage || monitor.active_limits().holds_force());
}

TEST_F(SafetyMonitorTest, TripsOnAWindingThatMayBeTooHot) {
    start_up();
    Observation loaded = calm();
    loaded.current_A = Vector3(0.0, 3.5, 0.0);
    const double limit_C = device.motor[1].thermal.max_winding_C;
    int ticks = 0;
    while (monitor.status().state != SafetyState::tripped && ticks < 60000) {
        EXPECT_LE(monitor.windings()[1].max_C, limit_C);
        pass(loaded);
        ++ticks;
    }
    EXPECT_EQ(monitor.status().cause, TripCause::winding_temperature);
    EXPECT_GT(monitor.status().measured, limit_C);
    EXPECT_EQ(monitor.status().limit, limit_C);
    EXPECT_NE(description(monitor.status()).find("limit 100.0 °C"), std::string::npos);
    // A reset does not cool it: the monitor tracks the temperature over time.
    monitor.reset();
    expect_braking(pass(calm()));
    EXPECT_EQ(monitor.status().state, SafetyState::tripped);
    pass_calm(1000);
    monitor.reset();
    start_up();
    EXPECT_GT(pass(calm()).e_W_V[0], 0.0);
}

TEST_F(SafetyMonitorTest, LimitsCancelledResistanceToTheColdestWinding) {
    start_up();
    // R may be 5 % lower than the file says, and the amplifier's sensor may read 1 % too much.
    device::MotorParameters least = device.motor[0];
    least.resistance_Ohm *= 0.94;
    const double limit_Ohm = (1.0 - device::kMinResidualShare) *
                             device::min_resistance_Ohm(least, device::kColdestAir_C);
    device::DeviceCommand requested = little();
    requested.cancelled_resistance_Ohm =
        Vector3(0.999 * limit_Ohm, 1.001 * limit_Ohm, device.motor[2].resistance_Ohm);
    const device::DeviceCommand command = pass(calm(), {}, requested);
    EXPECT_EQ(command.cancelled_resistance_Ohm, Vector3(0.999 * limit_Ohm, limit_Ohm, limit_Ohm));
    EXPECT_FALSE(monitor.windings()[0].is_limited);
    EXPECT_TRUE(monitor.windings()[1].is_limited);
    EXPECT_TRUE(monitor.windings()[2].is_limited);
}

TEST_F(SafetyMonitorTest, RHatFollowsACoolingWinding) {
    start_up();
    // On a winding that is certainly warm, R̂ may exceed what 25 °C of the data sheet allows...
    device::DeviceCommand requested = little();
    requested.cancelled_resistance_Ohm = Vector3::Constant(0.935 * device.motor[0].resistance_Ohm);
    Observation loaded = calm();
    loaded.current_A = Vector3::Constant(2.0);
    for (int i = 0; i < 30000; ++i) {
        pass(loaded, {}, requested);
    }
    ASSERT_NE(monitor.status().state, SafetyState::tripped);
    const Vector3 hot_Ohm = pass(loaded, {}, requested).cancelled_resistance_Ohm;
    EXPECT_EQ(hot_Ohm, requested.cancelled_resistance_Ohm);
    EXPECT_FALSE(monitor.windings()[0].is_limited);
    // ...and decreases as the winding cools, whatever the operator still requests.
    for (int i = 0; i < 60000; ++i) {
        const double R_hat_Ohm = pass(calm(), {}, requested).cancelled_resistance_Ohm[0];
        ASSERT_LT(R_hat_Ohm,
                  device::min_resistance_Ohm(device.motor[0], monitor.windings()[0].min_C));
    }
    EXPECT_TRUE(monitor.windings()[0].is_limited);
}

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
    pass_calm(600); // half-way up
    ASSERT_EQ(monitor.status().state, SafetyState::starting);
    const double top = monitor.status().ramp;
    for (int tick = 0; tick < 100; ++tick) {
        pass(calm(), to_release());
    }
    EXPECT_NEAR(monitor.status().ramp, top - 0.1, 1e-9);
    pass_calm(100);
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

// A current that doubles by itself, twice.
TEST_F(SafetyMonitorTest, LowersRHatAtOnceWhereAWindingGeneratesUntilAReset) {
    for (const bool has_inductance : {false, true}) {
        monitor = SafetyMonitor(device, kPeriod_s);
        start_up();
        const double before_Ohm = monitor.windings()[1].R_hat_limit_Ohm;
        Observation seen = calm();
        seen.has_inductance = has_inductance;
        for (const double before_A : {0.5, 0.5, 1.0}) {
            EXPECT_FALSE(monitor.windings()[1].generates);
            const double after_A = seen.interval[1] ? 2.0 * before_A : before_A;
            seen.interval[1] =
                control::DrivenInterval{kPeriod_s, 0.0, 0.0, 0.0, 1.8, before_A, after_A, 0.0, 0.0};
            pass(seen);
        }
        EXPECT_EQ(monitor.windings()[1].generates, has_inductance);
        EXPECT_EQ(monitor.windings()[1].is_contradicted, has_inductance);
        EXPECT_FALSE(monitor.windings()[0].generates);
        if (!has_inductance) {
            continue;
        }
        // Of the two intervals, t 2 ms: R̂ + (2 W − V_b t)/∫i dt, W = −L Δi.
        const device::MotorParameters &motor = device.motor[1];
        const double limit_Ohm =
            1.8 - (2.0 * motor.inductance_H * 1.5 + motor.max_brush_voltage_V * 2e-3) / 2.25e-3;
        EXPECT_NEAR(monitor.windings()[1].R_hat_limit_Ohm, limit_Ohm, 1e-5); // of float
        const device::DeviceCommand command = pass(calm());
        EXPECT_NEAR(command.cancelled_resistance_Ohm[1], limit_Ohm, 1e-5);
        EXPECT_EQ(command.cancelled_resistance_Ohm[0], 1.5);
        pass_calm(1000);
        EXPECT_NEAR(monitor.windings()[1].R_hat_limit_Ohm, limit_Ohm, 1e-5);

        SafetyOrders stop;
        stop.requested_stop = 1;
        pass(calm(), stop);
        EXPECT_TRUE(monitor.windings()[1].generates); // a stop alone is no reset
        ASSERT_TRUE(monitor.reset(1));
        pass_calm(1);
        EXPECT_FALSE(monitor.windings()[1].generates);
        EXPECT_LT(monitor.windings()[1].R_hat_limit_Ohm, limit_Ohm + 0.1); // rises slowly
        pass_calm(5000);
        EXPECT_NEAR(monitor.windings()[1].R_hat_limit_Ohm, before_Ohm, 0.01);
    }
}

} // namespace
} // namespace springdrive::servo
