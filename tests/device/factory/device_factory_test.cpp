// Covers device/factory/device_factory.cpp: opening, zeroing, closing and reconnecting in every
// order.
#include "device/factory/device_factory.h"

#include "base/input_error.h"
#include "device/core/phantom/kinematics.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <utility>

namespace springdrive::factory {
namespace {

const Vector3 kStart_m(0.01, 0.02, -0.01);
const Vector3 kElsewhere_rad(0.3, -0.2, 0.1);

DeviceRequest request() {
    DeviceRequest requested;
    requested.description = testing::phantom_1_0();
    requested.start_tip_m = kStart_m;
    return requested;
}

Vector3 theta_rad(const OpenDevice &open, const device::Measurement &measured) {
    const double rad_per_count = open.device().description().rad_per_count();
    return rad_per_count * Vector3(measured.counts[0], measured.counts[1], measured.counts[2]);
}

std::string error_about(const DeviceRequest &requested) {
    try {
        static_cast<void>(open_device(requested));
    } catch (const InputError &error) {
        return error.what();
    }
    return "";
}

TEST(DeviceFactory, OpensWhatIsPresentByKindAndSerial) {
    ASSERT_EQ(devices_present().front().kind, DeviceKind::simulated);
    EXPECT_EQ(devices_present().front().problem, "");
    DeviceRequest requested = request();
    requested.serial = devices_present().front().serial;
    OpenDevice open = open_device(requested);
    EXPECT_EQ(open.identity().kind, "simulated");
    EXPECT_EQ(open.identity().serial, requested.serial);
    EXPECT_EQ(open.state(), DeviceState::zeroed);
    EXPECT_NE(open.world(), nullptr);
    EXPECT_EQ(open.device().read().health, device::DeviceHealth::ok);
}

TEST(DeviceFactory, ReportsAMissingDeviceInOneLine) {
    DeviceRequest requested = request();
    requested.serial = "4711";
    EXPECT_NE(error_about(requested).find("4711"), std::string::npos);
    requested = request();
    requested.kind = DeviceKind::usb;
    requested.serial = "no such board";
    EXPECT_NE(error_about(requested).find("USB"), std::string::npos);
    requested = request();
    requested.start_tip_m = Vector3(5.0, 0.0, 0.0);
    EXPECT_NE(error_about(requested), "");
    requested = request();
    requested.period_s = -1.0;
    EXPECT_NE(error_about(requested), "");
    EXPECT_EQ(device_kind_named("sim"), DeviceKind::simulated);
    EXPECT_EQ(device_kind_named("usb"), DeviceKind::usb);
    EXPECT_FALSE(device_kind_named("serial"));
}

TEST(DeviceFactory, TheSimulatedDeviceStartsZeroed) {
    OpenDevice open = open_device(request());
    const device::PhantomGeometry &geometry = open.device().description().geometry;
    const Vector3 theta = theta_rad(open, open.device().read());
    const Vector3 tip_m =
        device::tip_position_m(geometry, device::joint_from_motor(geometry, theta));
    EXPECT_LT((tip_m - kStart_m).norm(), 1e-3); // up to counts and the hand's deflection under its
                                                // weight
}

/// The state that a device must have after a call, in any previous state.
enum class Call : std::uint8_t { zero, close, reconnect };

void make(Call call, OpenDevice &open, DeviceState &expected) {
    switch (call) {
    case Call::zero:
        if (expected == DeviceState::closed) {
            EXPECT_THROW(open.zero(kElsewhere_rad), InputError);
        } else {
            open.zero(kElsewhere_rad);
            expected = DeviceState::zeroed;
        }
        break;
    case Call::close:
        open.close();
        expected = DeviceState::closed;
        break;
    case Call::reconnect:
        open.reconnect();
        expected = DeviceState::open;
        break;
    }
}

TEST(DeviceFactory, StateIsCorrectAfterEveryOrderOfFourCalls) {
    constexpr std::array kCalls{Call::zero, Call::close, Call::reconnect};
    for (int order = 0; order < 81; ++order) {
        OpenDevice open = open_device(request());
        const device::HapticDevice *const device = &open.device();
        DeviceState expected = DeviceState::zeroed;
        for (int rest = order, n = 0; n < 4; ++n, rest /= 3) {
            const Call call = kCalls[static_cast<std::size_t>(rest % 3)];
            make(call, open, expected);
            ASSERT_EQ(open.state(), expected) << order << ", call " << n;
            const device::Measurement measured = open.device().read();
            const bool is_closed = expected == DeviceState::closed;
            ASSERT_EQ(measured.health,
                      is_closed ? device::DeviceHealth::lost : device::DeviceHealth::ok);
            ASSERT_EQ(device::is_new(measured.arrival), !is_closed);
            const double tolerance_rad = 40.0 * device->description().rad_per_count();
            if (call == Call::zero && !is_closed) {
                ASSERT_LT((theta_rad(open, measured) - kElsewhere_rad).norm(), tolerance_rad);
            } else if (call == Call::reconnect) { // counts start at the present position
                ASSERT_LT(theta_rad(open, measured).norm(), tolerance_rad);
            }
        }
        EXPECT_EQ(&open.device(), device);
    }
}

TEST(DeviceFactory, AClosedDeviceBrakesForAnyCommand) {
    OpenDevice open = open_device(request());
    device::DeviceCommand command;
    command.e_W_V = Vector3(2.0, 2.0, 2.0);
    const auto max_current_A = [&] {
        double max_A = 0.0;
        for (int tick = 0; tick < 50; ++tick) {
            open.device().write(command);
            max_A = std::max(max_A, open.device().read().current_A.cwiseAbs().maxCoeff());
        }
        return max_A;
    };
    EXPECT_GT(max_current_A(), 0.5);
    open.close();
    max_current_A(); // while motion decays
    EXPECT_LT(max_current_A(), 0.3);
    open.reconnect(); // a command from before is no longer active
    EXPECT_LT(open.device().read().current_A.cwiseAbs().maxCoeff(), 0.3);
    EXPECT_GT(max_current_A(), 0.5);
}

TEST(DeviceFactory, TimeAndNumbersContinueWhileClosed) {
    OpenDevice open = open_device(request());
    const device::Measurement before = open.device().read();
    open.close();
    static_cast<void>(open.device().read());
    open.reconnect();
    const device::Measurement after = open.device().read();
    EXPECT_EQ(after.number, before.number + 2);
    EXPECT_GT(after.time_s, before.time_s);
}

TEST(DeviceFactory, AssignmentClosesThePreviousDevice) {
    OpenDevice open = open_device(request());
    OpenDevice other = open_device(request());
    const device::HapticDevice *const taken = &other.device();
    open = std::move(other);
    EXPECT_EQ(&open.device(), taken);
    EXPECT_EQ(open.state(), DeviceState::zeroed);
    EXPECT_EQ(open.device().read().health, device::DeviceHealth::ok);
}

} // namespace
} // namespace springdrive::factory
