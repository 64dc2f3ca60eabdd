// A safety monitor and its inputs, for the tests of its start and of its trips.
#pragma once

#include "device/core/phantom/kinematics.h"
#include "engine/servo/safety_monitor.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

namespace springdrive::testing {

class SafetyMonitorTest : public ::testing::Test {
protected:
    static constexpr double kPeriod_s = 1e-3;

    /// A command so small that no limit reduces it.
    static device::DeviceCommand little() {
        return {Vector3(0.2, -0.3, 0.1), Vector3::Constant(1.5)};
    }

    /// The device at rest at joint angles, in free space, without current.
    [[nodiscard]] servo::Observation at(const Vector3 &q_rad) const {
        servo::Observation seen;
        seen.now.theta_rad = device::motor_from_joint(device.geometry, q_rad);
        seen.now.tip_m = device::tip_position_m(device.geometry, q_rad);
        seen.now.J = device::motor_jacobian(device.geometry, q_rad);
        seen.motors = control::motors_of_file(device.motor);
        return seen;
    }
    [[nodiscard]] servo::Observation calm() const { return at(Vector3(0.0, 0.2, 0.1)); }

    device::DeviceCommand pass(const servo::Observation &seen,
                               const servo::SafetyOrders &orders = {},
                               const device::DeviceCommand &requested = little()) {
        return monitor.pass(requested, seen, orders);
    }

    void pass_calm(int ticks) {
        for (int i = 0; i < ticks; ++i) {
            pass(calm());
        }
    }

    /// From waiting or starting to running, in free space.
    void start_up() {
        pass_calm(1110);
        ASSERT_EQ(monitor.status().state, servo::SafetyState::running)
            << servo::description(monitor.status());
    }

    static void expect_braking(const device::DeviceCommand &command) {
        EXPECT_EQ(command.e_W_V, Vector3::Zero());
        EXPECT_EQ(command.cancelled_resistance_Ohm, Vector3::Zero());
    }

    device::DeviceDescription device = phantom_1_0();
    servo::SafetyMonitor monitor{device, kPeriod_s};
};

} // namespace springdrive::testing
