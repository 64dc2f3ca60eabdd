// Covers device/factory/emulated_device.cpp: an emulated board as a device of its own kind.
#include "device/factory/emulated_device.h"

#include "base/input_error.h"
#include "device/factory/device_factory.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace springdrive::factory {
namespace {

DeviceRequest emulated_request() {
    DeviceRequest request;
    request.kind = DeviceKind::emulated;
    request.description = testing::phantom_1_0();
    return request;
}

device::Measurement braked_tick(OpenDevice &open) {
    const device::Measurement measured = open.device().read();
    device::DeviceCommand command = device::DeviceCommand::braking();
    command.number = measured.number;
    open.device().write(command);
    return measured;
}

TEST(EmulatedDevice, IsPresentAndOpenedByName) {
    EXPECT_EQ(device_kind_named("emulated"), DeviceKind::emulated);
    EXPECT_EQ(std::ranges::count(devices_present(), DeviceKind::emulated, &PresentDevice::kind), 1);
    OpenDevice open = open_device(emulated_request());
    EXPECT_EQ(open.identity().kind, "emulated");
    EXPECT_EQ(open.identity().serial, kEmulatedSerial);
    EXPECT_EQ(open.state(), DeviceState::open);
    EXPECT_EQ(open.world(), nullptr);
    EXPECT_NE(open.hand(), nullptr);
    EXPECT_NE(open.device().bench(), nullptr);
    DeviceRequest other = emulated_request();
    other.serial = "4711";
    EXPECT_NE(error_text_of([&] { static_cast<void>(open_device(other)); }).find("4711"),
              std::string::npos);
}

TEST(EmulatedDevice, EachSeedIsADeviceOfItsOwn) {
    DeviceRequest request = emulated_request();
    request.simulation.device_seed = 9;
    EXPECT_EQ(open_device(request).identity().serial, "emulated-9");
    EXPECT_EQ(emulated_serial(0), kEmulatedSerial);
    EXPECT_LE(emulated_serial(~std::uint64_t{0}).size(), usb::kSerialSize);
}

TEST(EmulatedDevice, APeriodPassesWithEachTickWhateverTheHostDoes) {
    DeviceRequest request = emulated_request();
    request.emulation.delay_periods = 0.5;
    OpenDevice open = open_device(request);
    device::Measurement before = braked_tick(open);
    for (int i = 0; i < 100; ++i) {
        const device::Measurement now = braked_tick(open);
        ASSERT_EQ(now.number, before.number + 1);
        ASSERT_NEAR(now.time_s - before.time_s, request.period_s, 1e-6); // the board's clock
        ASSERT_EQ(now.arrival, device::Arrival::fresh);
        before = now;
    }
    constexpr double kLoop_periods = 0.025; // at 40 kHz
    EXPECT_NEAR(open.device().delay_periods(), 0.5, kLoop_periods);
}

TEST(EmulatedDevice, IsLostWithoutItsCableAndTimePassesOn) {
    OpenDevice open = open_device(emulated_request());
    open.zero(Vector3::Zero());
    EXPECT_EQ(braked_tick(open).health, device::DeviceHealth::ok);
    open.emulated()->set_plugged(false);
    const double before_s = open.emulated()->board().time_s();
    for (int i = 0; i < 50; ++i) {
        ASSERT_EQ(braked_tick(open).health, device::DeviceHealth::lost);
    }
    EXPECT_NEAR(open.emulated()->board().time_s() - before_s, 0.05, 1e-3);
    EXPECT_THROW(open.reconnect(), InputError);
    open.emulated()->set_plugged(true);
    open.reconnect();
    EXPECT_EQ(open.state(), DeviceState::zeroed);
    EXPECT_EQ(braked_tick(open).health, device::DeviceHealth::ok);
}

TEST(EmulatedDevice, ShowsItsFaultsAndThatItIsAnotherMachine) {
    DeviceRequest request = emulated_request();
    request.emulation.faults = {device::parse_fault("stop")};
    OpenDevice open = open_device(request);
    EXPECT_TRUE(braked_tick(open).faults.has(device::BoardFaults::kStop));
    request = emulated_request();
    request.emulation.truth = testing::phantom_1_0();
    request.emulation.truth->encoder_counts_per_turn = 2000;
    const std::string error = error_text_of([&] { static_cast<void>(open_device(request)); });
    EXPECT_NE(error.find("2000 counts a turn"), std::string::npos) << error;
}

TEST(EmulatedDevice, StaysTheSameWhenItIsMoved) {
    OpenDevice open = open_device(emulated_request());
    OpenDevice other = open_device(emulated_request());
    const EmulatedDevice *const taken = other.emulated();
    open = std::move(other);
    EXPECT_EQ(open.emulated(), taken);
    EXPECT_EQ(braked_tick(open).health, device::DeviceHealth::ok);
}

} // namespace
} // namespace springdrive::factory
