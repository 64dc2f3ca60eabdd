// A safety monitor and what it is shown, for the tests of its start and of its trips.
#pragma once

#include "device/phantom/kinematics.h"
#include "engine/servo/safety_monitor.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

namespace springdrive::testing {

class SafetyMonitorTest : public ::testing::Test {
protected:
    static constexpr double kPeriod_s = 1e-3;

    /// So little that no limit holds any of it back.
    static DeviceCommand little() { return {Vector3(0.2, -0.3, 0.1), Vector3::Constant(1.5)}; }

    /// The device at rest at joint angles, in free space, without current.
    [[nodiscard]] Observation at(const Vector3 &q_rad) const {
        Observation seen;
        seen.now.theta_rad = motor_from_joint(device.geometry, q_rad);
        seen.now.tip_m = tip_position_m(device.geometry, q_rad);
        seen.now.J = motor_jacobian(device.geometry, q_rad);
        return seen;
    }
    [[nodiscard]] Observation calm() const { return at(Vector3(0.0, 0.2, 0.1)); }

    DeviceCommand pass(const Observation &seen, const SafetyOrders &orders = {},
                       const DeviceCommand &wanted = little()) {
        return monitor.pass(wanted, seen, orders);
    }

    /// From waiting or starting to running, in free space.
    void start_up() {
        for (int i = 0; i < 1110; ++i) {
            pass(calm());
        }
        ASSERT_EQ(monitor.status().state, SafetyState::running) << description(monitor.status());
    }

    static void expect_braking(const DeviceCommand &command) {
        EXPECT_EQ(command.e_W_V, Vector3::Zero());
        EXPECT_EQ(command.cancelled_resistance_Ohm, Vector3::Zero());
    }

    DeviceDescription device = phantom_1_0();
    SafetyMonitor monitor{device, kPeriod_s};
};

} // namespace springdrive::testing
