// Covers device/usb/board/self_test.{h,cpp}, with tests/device/usb/board_rig.h.
#include "tests/device/usb/board_rig.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <functional>

namespace springdrive::board {
namespace {

using testing::BoardRig;
using usb::ChannelFindings;
using usb::SelfTestState;

bool order(BoardRig &rig, float voltage_V = 0.5F, std::uint32_t pulse_us = 8000) {
    const auto payload = usb::encode(usb::SelfTestOrder{voltage_V, pulse_us});
    return rig.board().control_out(static_cast<std::uint8_t>(usb::Kind::self_test), payload.data(),
                                   payload.size());
}

usb::SelfTestResult result(BoardRig &rig) {
    std::array<std::uint8_t, kMaxPayload> payload{};
    const std::size_t size =
        rig.board().control_in(static_cast<std::uint8_t>(usb::Kind::self_test), 0, payload.data());
    usb::SelfTestResult result;
    EXPECT_EQ(usb::decode(payload.data(), size, result), usb::FrameStatus::ok);
    return result;
}

/// A rig with free rotors, damaged by `damage`, after its self-test.
usb::SelfTestResult tested(const std::function<void(BoardRig &)> &damage = {}) {
    BoardRig rig;
    for (testing::RigMotor &motor : rig.motor) {
        motor.is_held = false;
    }
    if (damage) {
        damage(rig);
    }
    rig.start();
    EXPECT_TRUE(order(rig));
    rig.run_ms(600);
    EXPECT_EQ(rig.state(), State::braking);
    return result(rig);
}

TEST(SelfTest, MeasuresResistancesAndInductancesAndFindsNothingWrong) {
    const usb::SelfTestResult result = tested([](BoardRig &rig) {
        rig.motor[1].resistance_Ohm = 2.4;
        rig.motor[1].inductance_H = 0.119e-3;
        rig.motor[2].inductance_H = 0.357e-3;
        rig.motor[2].sensor_offset_A = 0.05;
    });
    EXPECT_EQ(result.state, SelfTestState::completed);
    const std::array<double, 3> expected_Ohm{2.18, 2.4, 2.18};
    const std::array<double, 3> expected_H{0.238e-3, 0.119e-3, 0.357e-3};
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(result.channel[i].findings, 0) << i;
        // Of the back-EMF remains what the rotor's speed is not symmetrical.
        EXPECT_NEAR(result.channel[i].resistance_Ohm, expected_Ohm[i], 0.01 * expected_Ohm[i]);
        // The sum in place of the integral, (R T/L)²/24 = 1.1 % at most, and what the back-EMF
        // bends the line.
        EXPECT_NEAR(result.channel[i].inductance_H, expected_H[i], 0.02 * expected_H[i]);
        EXPECT_GE(result.channel[i].moved_counts[i], 3);
    }
}

TEST(SelfTest, FindsWhatIsWrong) {
    const auto findings = [](const std::function<void(BoardRig &)> &damage) {
        const usb::SelfTestResult found = tested(damage);
        EXPECT_EQ(found.state, SelfTestState::completed);
        return std::array<int, 3>{found.channel[0].findings, found.channel[1].findings,
                                  found.channel[2].findings};
    };
    using Findings = std::array<int, 3>;
    EXPECT_EQ(findings([](BoardRig &rig) { rig.motor[1].resistance_Ohm = 1e6; }),
              (Findings{0, ChannelFindings::kOpenWinding | ChannelFindings::kNoMotion, 0}));
    EXPECT_EQ(findings([](BoardRig &rig) { rig.motor[2].sensor_gain = -1.0; }),
              (Findings{0, 0, ChannelFindings::kReversedSensor}));
    EXPECT_EQ(findings([](BoardRig &rig) { rig.encoder_sign[0] = -1.0; }),
              (Findings{ChannelFindings::kReversedEncoder, 0, 0}));
    EXPECT_EQ(findings([](BoardRig &rig) { rig.motor[0].is_held = true; }),
              (Findings{ChannelFindings::kNoMotion, 0, 0}));
    EXPECT_EQ(findings([](BoardRig &rig) {
                  rig.motor_of_encoder = {0, 2, 1};
              }),
              (Findings{0, ChannelFindings::kCrossedEncoder, ChannelFindings::kCrossedEncoder}));
    EXPECT_EQ(findings([](BoardRig &rig) {
                  rig.motor_of_sensor = {1, 0, 2};
              }),
              (Findings{ChannelFindings::kOpenWinding | ChannelFindings::kCrossedSensor,
                        ChannelFindings::kOpenWinding | ChannelFindings::kCrossedSensor, 0}));
    EXPECT_EQ(findings([](BoardRig &rig) { rig.encoder_sign[2] = 0.0; }),
              (Findings{0, 0, ChannelFindings::kNoMotion}));
}

TEST(SelfTest, AbortsAtItsLimits) {
    const usb::SelfTestResult shorted =
        tested([](BoardRig &rig) { rig.motor[1].resistance_Ohm = 0.3; });
    EXPECT_EQ(shorted.state, SelfTestState::aborted);
    EXPECT_EQ(shorted.channel[1].findings, ChannelFindings::kLimit);
    const usb::SelfTestResult runaway = tested([](BoardRig &rig) {
        rig.motor[0].inertia_kg_m2 = 5e-8;
        rig.motor[0].damping_Nms_per_rad = 0.0;
    });
    EXPECT_EQ(runaway.state, SelfTestState::completed); // the −V pulse and braking end it in time
    BoardRig rig;
    rig.start();
    EXPECT_TRUE(order(rig));
    rig.run_ms(3);
    rig.motor[0].angle_rad = 0.95; // in steps that a motor can make
    rig.run_ms(3);
    EXPECT_NE(rig.state(), State::testing);
}

TEST(SelfTest, EndsWithTheHostsSilenceAndItsCommands) {
    BoardRig rig;
    rig.start();
    EXPECT_TRUE(order(rig));
    rig.run_ms(2);
    EXPECT_EQ(rig.state(), State::testing);
    rig.host_sends = false;
    rig.run_ms(7);
    EXPECT_EQ(rig.state(), State::fault_braking);
    rig.run_ms(2);
    EXPECT_EQ(result(rig).state, SelfTestState::aborted);

    BoardRig second;
    second.start();
    EXPECT_TRUE(order(second));
    second.run_ms(2);
    second.command.mode = usb::Mode::drive;
    second.run_loops(41);
    second.command.mode = usb::Mode::brake;
    EXPECT_NE(second.state(), State::testing);
    second.run_ms(3);
    EXPECT_EQ(result(second).state, SelfTestState::aborted);
}

TEST(SelfTest, OnlyWithinItsLimitsAndWhileBraking) {
    BoardRig rig;
    EXPECT_FALSE(order(rig)); // starting
    rig.start();
    EXPECT_FALSE(order(rig, 1.001F));
    EXPECT_FALSE(order(rig, 0.5F, 20'001));
    EXPECT_FALSE(order(rig, 0.5F, 7999)); // 319 loops
    EXPECT_TRUE(order(rig, 1.0F, 20'000));
    rig.run_ms(1);
    EXPECT_FALSE(order(rig)); // testing
}

} // namespace
} // namespace springdrive::board
