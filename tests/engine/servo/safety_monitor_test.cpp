// Covers engine/servo/safety_monitor.cpp.
#include "engine/servo/safety_monitor.h"

#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>

namespace springdrive {
namespace {

constexpr double kPeriod_s = 1e-3;
const DeviceCommand kWanted{Vector3(1.0, -2.0, 0.5), Vector3::Constant(1.5)};

class SafetyMonitorTest : public ::testing::Test {
protected:
    DeviceCommand pass(const SafetyMonitor::Measurement &measured, bool stop = false,
                       const DeviceCommand &wanted = kWanted) {
        return monitor.pass(wanted, measured, stop);
    }

    void ramp_up() {
        for (int i = 0; i < 1000; ++i) {
            pass({});
        }
        ASSERT_EQ(monitor.status().state, SafetyState::running);
    }

    void expect_braking(const DeviceCommand &command) {
        EXPECT_EQ(command.e_W_V, Vector3::Zero());
        EXPECT_EQ(command.cancelled_resistance_Ohm, Vector3::Zero());
    }

    /// Just within the limit nothing happens; beyond it the monitor trips, latches, and recovers
    /// only by a reset.
    void expect_trip(const SafetyMonitor::Measurement &within,
                     const SafetyMonitor::Measurement &beyond, TripCause cause,
                     int ticks_tolerated = 0) {
        ramp_up();
        for (int i = 0; i < 100; ++i) {
            EXPECT_EQ(pass(within).e_W_V, kWanted.e_W_V);
        }
        for (int i = 0; i < ticks_tolerated; ++i) {
            EXPECT_EQ(pass(beyond).e_W_V, kWanted.e_W_V);
        }
        expect_braking(pass(beyond));
        EXPECT_EQ(monitor.status().cause, cause);
        expect_braking(pass({}));
        EXPECT_EQ(monitor.status().state, SafetyState::tripped);
        monitor.reset();
        pass({});
        EXPECT_EQ(monitor.status().state, SafetyState::starting);
    }

    DeviceDescription device = testing::phantom_1_0();
    SafetyMonitor monitor{device, kPeriod_s};
};

TEST_F(SafetyMonitorTest, RampsFromNothingToTheWholeCommand) {
    double before = 0.0;
    while (monitor.status().state == SafetyState::starting) {
        const DeviceCommand command = pass({});
        EXPECT_GT(command.e_W_V[0], before);
        EXPECT_LE(command.e_W_V[0] - before, 0.01 * kWanted.e_W_V[0]);
        before = command.e_W_V[0];
    }
    EXPECT_EQ(pass({}).e_W_V, kWanted.e_W_V);
}

TEST_F(SafetyMonitorTest, TripsOnTipSpeed) {
    SafetyMonitor::Measurement within;
    SafetyMonitor::Measurement beyond;
    const double limit = device.limits.tip_speed_m_per_s;
    within.tip_velocity_m_per_s = Vector3(0.0, 0.999 * limit, 0.0);
    beyond.tip_velocity_m_per_s = Vector3(0.0, 1.001 * limit, 0.0);
    expect_trip(within, beyond, TripCause::tip_speed);
}

TEST_F(SafetyMonitorTest, TripsOnLastingTipForce) {
    SafetyMonitor::Measurement within;
    SafetyMonitor::Measurement beyond;
    const double limit = device.limits.tip_force_N;
    within.tip_force_N = Vector3(0.999 * limit, 0.0, 0.0);
    beyond.tip_force_N = Vector3(1.001 * limit, 0.0, 0.0);
    expect_trip(within, beyond, TripCause::tip_force, 20);
}

TEST_F(SafetyMonitorTest, TripsOnCurrent) {
    SafetyMonitor::Measurement within;
    SafetyMonitor::Measurement beyond;
    const double limit = device.motor[2].peak_current_A;
    within.current_A = Vector3(0.0, 0.0, -0.999 * limit);
    beyond.current_A = Vector3(0.0, 0.0, -1.001 * limit);
    expect_trip(within, beyond, TripCause::current);
}

TEST_F(SafetyMonitorTest, TripsOnALostDevice) {
    SafetyMonitor::Measurement lost;
    lost.health = DeviceHealth::lost;
    expect_trip({}, lost, TripCause::device_lost);
}

TEST_F(SafetyMonitorTest, TripsOnWhateverIsNotFinite) {
    SafetyMonitor::Measurement bad;
    bad.all_finite = false;
    expect_trip({}, bad, TripCause::not_finite);
    for (const double value : {static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
        bad = {};
        bad.tip_force_N[1] = value;
        expect_trip({}, bad, TripCause::not_finite);
        bad = {};
        bad.tip_velocity_m_per_s[0] = value;
        expect_trip({}, bad, TripCause::not_finite);
        bad = {};
        bad.current_A[2] = value;
        expect_trip({}, bad, TripCause::not_finite);
        ramp_up();
        expect_braking(pass({}, false, {Vector3(0.0, value, 0.0), Vector3::Zero()}));
        monitor.reset();
    }
}

TEST_F(SafetyMonitorTest, AnEmergencyStopOutlastsAResetWhileItIsPressed) {
    ramp_up();
    expect_braking(pass({}, true));
    EXPECT_EQ(monitor.status().cause, TripCause::emergency_stop);
    monitor.reset();
    expect_braking(pass({}, true));
    expect_braking(pass({}));
    monitor.reset();
    EXPECT_GT(pass({}).e_W_V[0], 0.0);
}

TEST_F(SafetyMonitorTest, NamesTheFirstCause) {
    ramp_up();
    SafetyMonitor::Measurement fast;
    fast.tip_velocity_m_per_s = Vector3(0.0, 7.0, 0.0);
    pass(fast);
    pass({}, true);
    EXPECT_EQ(monitor.status().cause, TripCause::tip_speed);
    EXPECT_DOUBLE_EQ(monitor.status().measured, 7.0);
    EXPECT_DOUBLE_EQ(monitor.status().limit, device.limits.tip_speed_m_per_s);
}

TEST_F(SafetyMonitorTest, HoldsCommandsToSupplyAndResistance) {
    ramp_up();
    const DeviceCommand command =
        pass({}, false, {Vector3(1e3, -1e3, 0.0), Vector3(10.0, -1.0, 2.0)});
    EXPECT_EQ(command.e_W_V, Vector3(device.motor[0].supply_V, -device.motor[1].supply_V, 0.0));
    for (int j = 0; j < 3; ++j) {
        EXPECT_GE(command.cancelled_resistance_Ohm[j], 0.0);
        EXPECT_LT(command.cancelled_resistance_Ohm[j], device.motor[0].resistance_Ohm);
    }
}

TEST_F(SafetyMonitorTest, TripsOnAWindingThatMayBeTooHot) {
    ramp_up();
    SafetyMonitor::Measurement loaded;
    loaded.current_A = Vector3(0.0, 3.5, 0.0);
    const double limit_C = device.motor[1].thermal.greatest_winding_C;
    int ticks = 0;
    while (monitor.status().state != SafetyState::tripped && ticks < 60000) {
        EXPECT_LE(monitor.windings()[1].greatest_C, limit_C);
        pass(loaded);
        ++ticks;
    }
    EXPECT_EQ(monitor.status().cause, TripCause::winding_temperature);
    EXPECT_GT(monitor.status().measured, limit_C);
    EXPECT_EQ(monitor.status().limit, limit_C);
    EXPECT_NE(description(monitor.status()).find("limit 100.00 °C"), std::string::npos);
    // A reset does not cool it: that takes time, of which the monitor keeps count.
    monitor.reset();
    expect_braking(pass({}));
    for (int i = 0; i < 1000; ++i) {
        pass({});
    }
    monitor.reset();
    EXPECT_GT(pass({}).e_W_V[0], 0.0);
    EXPECT_EQ(monitor.status().state, SafetyState::starting);
}

TEST_F(SafetyMonitorTest, LimitsCancelledResistanceToTheColdestWinding) {
    ramp_up();
    const double limit_Ohm =
        (1.0 - kLeastResidualShare) * least_resistance_Ohm(device.motor[0], kColdestAir_C);
    DeviceCommand wanted = kWanted;
    wanted.cancelled_resistance_Ohm =
        Vector3(0.999 * limit_Ohm, 1.001 * limit_Ohm, device.motor[2].resistance_Ohm);
    const DeviceCommand command = pass({}, false, wanted);
    EXPECT_EQ(command.cancelled_resistance_Ohm, Vector3(0.999 * limit_Ohm, limit_Ohm, limit_Ohm));
    EXPECT_FALSE(monitor.windings()[0].is_limited);
    EXPECT_TRUE(monitor.windings()[1].is_limited);
    EXPECT_TRUE(monitor.windings()[2].is_limited);
}

TEST_F(SafetyMonitorTest, TunedHotThenCooledARHatFollowsTheWinding) {
    ramp_up();
    // Tuned on a winding that surely is warm, R̂ may exceed what the data sheet's 25 °C allows...
    DeviceCommand wanted = kWanted;
    wanted.cancelled_resistance_Ohm = Vector3::Constant(device.motor[0].resistance_Ohm);
    SafetyMonitor::Measurement loaded;
    loaded.current_A = Vector3::Constant(2.0);
    for (int i = 0; i < 30000; ++i) {
        pass(loaded, false, wanted);
    }
    ASSERT_NE(monitor.status().state, SafetyState::tripped);
    const Vector3 hot_Ohm = pass(loaded, false, wanted).cancelled_resistance_Ohm;
    EXPECT_EQ(hot_Ohm, wanted.cancelled_resistance_Ohm);
    EXPECT_FALSE(monitor.windings()[0].is_limited);
    // ...and comes down with the winding as it cools, whatever the operator still asks for.
    for (int i = 0; i < 60000; ++i) {
        const double R_hat_Ohm = pass({}, false, wanted).cancelled_resistance_Ohm[0];
        ASSERT_LT(R_hat_Ohm, least_resistance_Ohm(device.motor[0], monitor.windings()[0].least_C));
    }
    EXPECT_TRUE(monitor.windings()[0].is_limited);
}

} // namespace
} // namespace springdrive
