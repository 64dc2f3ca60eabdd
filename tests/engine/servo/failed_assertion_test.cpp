// Covers engine/servo/servo.cpp and servo_loop.cpp: an assertion that fails in a tick.
#include "base/assertions.h"
#include "device/core/forwarding_device.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/servo/servo.h"
#include "tests/support/devices.h"
#include "tests/support/planted_device.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

namespace springdrive::servo {
namespace {

using testing::Plant;
using testing::PlantedDevice;

constexpr int kPressing = 1900; // ticks, by when the tip is deep in the plate

/// A hand presses the tip of a device with a planted bug into a plate.
struct Pressed {
    explicit Pressed(Plant plant, double servo_hz = 1000.0)
        : device(plant, hand()), servo(device, servo_hz) {
        inputs.surface = &plate;
        inputs.scene_id = 1;
        servo.publish(inputs);
    }

    static std::vector<simulated::HandPath::Point> hand() {
        return {{1.2, testing::kPlantedStart_m}, {1.6, Vector3(0.0, -0.01, 0.0)}};
    }

    void take_in() {
        servo.drain([&](const ServoSample &sample) { samples.push_back(sample); });
    }

    /// Waits until the servo's thread has completed `ticks` more ticks.
    void wait_for(std::size_t ticks) {
        for (const std::size_t end = samples.size() + ticks; samples.size() < end; take_in()) {
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
    }

    contact::HapticSurface plate{
        testing::box_soup(Vector3(-0.05, -0.02, -0.05), Vector3(0.05, 0.0, 0.05))};
    PlantedDevice device;
    Servo servo;
    ServoInputs inputs;
    std::vector<ServoSample> samples;
};

/// From the failure on the device received only braking commands, and before that it was driven.
void expect_braked(const PlantedDevice &device) {
    const std::vector<device::DeviceCommand> &received = device.received();
    const std::size_t failed = device.received_before_failure();
    ASSERT_GT(failed, 0U);
    ASSERT_LT(failed, received.size());
    EXPECT_GT(received[failed - 1].e_W_V.norm(), 0.1);
    EXPECT_GT(received[failed - 1].cancelled_resistance_Ohm.minCoeff(), 1.0);
    for (std::size_t i = failed; i < received.size(); ++i) {
        ASSERT_EQ(received[i].mode, device::CommandMode::brake) << i - failed;
        ASSERT_TRUE(received[i].e_W_V.isZero(0.0)) << i - failed;
        ASSERT_TRUE(received[i].cancelled_resistance_Ohm.isZero(0.0)) << i - failed;
    }
}

void expect_said(const SafetyStatus &status, const testing::PlantedLimit &line) {
    EXPECT_EQ(status.state, SafetyState::tripped);
    EXPECT_EQ(status.cause, TripCause::assertion);
    EXPECT_STREQ(status.failure.condition, line.condition);
    EXPECT_STREQ(status.failure.file, "tests/support/planted_device.h");
    EXPECT_EQ(status.failure.line, line.line);
    EXPECT_EQ(description(status),
              "internal error, assertion failed at tests/support/planted_device.h:" +
                  std::to_string(line.line) + ": " + line.condition + "; restart the program");
}

class FailedAssertion : public ::testing::TestWithParam<Plant> {};

TEST_P(FailedAssertion, TheDeviceReceivesOnlyBrakingCommandsFromThenOn) {
    Pressed rig(GetParam());
    rig.servo.advance(kPressing);
    rig.device.arm();
    rig.servo.advance(500);
    rig.take_in();
    expect_braked(rig.device);
    // No tick is missing, and all since report the failure.
    ASSERT_EQ(rig.samples.size(), kPressing + 500U);
    for (std::size_t i = 0; i < rig.samples.size(); ++i) {
        ASSERT_EQ(rig.samples[i].tick, i);
        ASSERT_EQ(rig.samples[i].safety.state == SafetyState::tripped, i >= kPressing) << i;
    }
    expect_said(rig.samples[kPressing].safety, rig.device.line());
    expect_said(rig.samples.back().safety, rig.device.line());
    EXPECT_TRUE(rig.samples.back().command.e_W_V.isZero(0.0));
    EXPECT_NE(rig.samples.back().counts, rig.samples[kPressing].counts); // it still measures
    EXPECT_NE(rig.samples.back().tip_m, rig.samples[kPressing].tip_m);
}

TEST_P(FailedAssertion, OnTheServosThreadToo) {
    Pressed rig(GetParam(), 4000.0);
    rig.servo.start();
    rig.wait_for(4 * std::size_t{kPressing});
    ASSERT_EQ(rig.samples.back().safety.state, SafetyState::running);
    rig.device.arm();
    while (rig.samples.back().safety.state != SafetyState::tripped) {
        rig.wait_for(1);
    }
    rig.wait_for(1000);
    rig.servo.stop();
    rig.take_in();
    expect_braked(rig.device);
    expect_said(rig.samples.back().safety, rig.device.line());
    for (std::size_t i = 0; i < rig.samples.size(); ++i) {
        ASSERT_EQ(rig.samples[i].tick, i);
    }
}

INSTANTIATE_TEST_SUITE_P(Servo, FailedAssertion,
                         ::testing::Values(Plant::in_read, Plant::in_update, Plant::in_write),
                         [](const auto &of) { return testing::name_of(of.param); });

TEST(ServoAssertion, OnlyARestartClearsIt) {
    Pressed rig(Plant::in_update);
    rig.servo.advance(kPressing);
    rig.device.arm();
    rig.servo.advance(1);
    rig.inputs.reset_count = 1;
    rig.servo.publish(rig.inputs);
    rig.servo.advance(100);
    rig.inputs.requested_stop = rig.inputs.released_stop = 1;
    rig.inputs.reset_count = 2;
    rig.inputs.release = true;
    rig.inputs.scene_id = 2; // tells the publisher that the first surface is no longer used
    rig.inputs.surface = nullptr;
    rig.servo.publish(rig.inputs);
    rig.servo.advance(100);
    rig.servo.set_rate(2000.0);
    rig.inputs.release = false;
    rig.servo.publish(rig.inputs);
    rig.servo.start(); // continues in the same state
    rig.take_in();
    EXPECT_EQ(rig.samples.back().scene_id, 2U);
    rig.wait_for(3000);
    rig.servo.pause();
    rig.inputs.reset_count = 3;
    rig.servo.publish(rig.inputs);
    rig.servo.resume();
    rig.wait_for(3000);
    rig.servo.stop();
    rig.take_in();
    expect_braked(rig.device);
    expect_said(rig.samples.back().safety, rig.device.line());
}

TEST(ServoAssertion, ASecondFailureWhileBrakingEndsTheTicksNotTheProgram) {
    for (const bool on_a_thread : {false, true}) {
        Pressed rig(Plant::in_read);
        rig.servo.advance(kPressing);
        rig.device.arm(2);
        if (on_a_thread) {
            rig.servo.start();
            while (rig.device.failures() < 2) {
                std::this_thread::sleep_for(std::chrono::milliseconds(2));
            }
        } else {
            rig.servo.advance(100);
        }
        rig.servo.stop();
        expect_braked(rig.device);
        EXPECT_EQ(rig.device.failures(), 2);
        // Once at each failure, and at the end.
        EXPECT_EQ(rig.device.received().size(), rig.device.received_before_failure() + 3);
    }
}

TEST(ServoAssertion, OpenWindingsStayOpen) {
    Pressed rig(Plant::in_update);
    rig.servo.advance(kPressing);
    rig.device.report(device::BoardFaults::kAmplifier);
    rig.servo.advance(1);
    ASSERT_EQ(rig.device.received().back().mode, device::CommandMode::open);
    rig.device.arm();
    rig.servo.advance(10);
    EXPECT_EQ(rig.device.failures(), 1);
    EXPECT_EQ(rig.device.received().back().mode, device::CommandMode::open);
    rig.take_in();
    expect_said(rig.samples.back().safety, rig.device.line()); // no longer the board's fault
}

TEST(ServoAssertionDeathTest, IfTheSafeCommandFailsTooTheProgramEnds) {
    Pressed rig(Plant::in_read);
    rig.servo.advance(kPressing);
    const auto go_on = [&] {
        rig.device.arm();
        rig.device.refuse_to_brake();
        rig.servo.advance(1);
    };
    EXPECT_DEATH(go_on(), "^told to brake\nspringdrive: assertion failed: !refuses_");
}

TEST(ServoAssertionDeathTest, AnUnguardedLoopEndsTheProgram) {
    PlantedDevice device(Plant::in_update, Pressed::hand());
    ServoLoop loop(device, 1e-3);
    static_cast<void>(loop.tick({}));
    device.arm();
    EXPECT_DEATH(static_cast<void>(loop.tick({})),
                 "assertion failed: .*, tests/support/planted_device\\.h:");
}

} // namespace
} // namespace springdrive::servo
