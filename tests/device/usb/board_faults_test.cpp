// Covers the faults that device/usb/board/loop.cpp finds, and device/usb/board/self_test.{h,cpp},
// with tests/device/usb/board_rig.h.
#include "tests/device/usb/board_rig.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <vector>

namespace springdrive::board {
namespace {

using testing::all_stages;
using testing::BoardRig;
using testing::drive;
using testing::DrivingRig;
using testing::mode;
using usb::ChannelFindings;
using usb::Faults;
using usb::SelfTestState;

struct FaultCase {
    const char *name;
    std::uint16_t fault;
    State state;
    std::function<void(Samples &)> tamper;
};

std::vector<FaultCase> fault_cases() {
    return {
        {"stage", Faults::kAmplifier, State::fault_open, [](Samples &s) { s.stage_failed = true; }},
        {"sensor", Faults::kSensor, State::fault_open,
         [](Samples &s) { s.current_A[1] = kNotMeasured; }},
        {"sensor infinite", Faults::kSensor, State::fault_open,
         [](Samples &s) { s.current_A[1] = std::numeric_limits<float>::infinity(); }},
        {"current", Faults::kOverCurrent, State::fault_braking,
         [](Samples &s) { s.current_A[0] = 6.61F; }},
        {"current, other way", Faults::kOverCurrent, State::fault_braking,
         [](Samples &s) { s.current_A[2] = -6.61F; }},
        {"supply low", Faults::kSupply, State::fault_braking,
         [](Samples &s) { s.supply_V = 12.99F; }},
        {"supply high", Faults::kSupply, State::fault_braking,
         [](Samples &s) { s.supply_V = 18.01F; }},
        {"supply unknown", Faults::kSupply, State::fault_braking,
         [](Samples &s) { s.supply_V = kNotMeasured; }},
        {"supply zero", Faults::kSupply, State::fault_braking,
         [](Samples &s) { s.supply_V = 0.0F; }},
        {"temperature", Faults::kTemperature, State::fault_braking,
         [](Samples &s) { s.temperature_C[0] = 85.1F; }},
        {"temperature unknown", Faults::kTemperature, State::fault_braking,
         [](Samples &s) { s.temperature_C[0] = kNotMeasured; }},
        {"stop switch", Faults::kStop, State::fault_braking,
         [](Samples &s) { s.is_stopped = true; }},
        {"enable line", Faults::kStop, State::fault_braking,
         [](Samples &s) { s.is_enabled = false; }},
    };
}

TEST(BoardFaults, BrakeOrOpenLatchAndNeedAReset) {
    for (const FaultCase &fault : fault_cases()) {
        SCOPED_TRACE(fault.name);
        DrivingRig rig;
        rig.tamper = fault.tamper;
        rig.run_loops(3 * 16 + 1); // slow checks, three times in a row
        EXPECT_EQ(rig.state(), fault.state);
        EXPECT_EQ(rig.faults(), fault.fault);
        EXPECT_TRUE(
            all_stages(rig.order, fault.state == State::fault_open ? Stage::open : Stage::brake));
        rig.command = mode(usb::Mode::brake);
        rig.begin(true);
        rig.run_loops(1);
        EXPECT_EQ(rig.state(), fault.state); // the cause persists: not even for a moment
        rig.run_ms(2);
        EXPECT_EQ(rig.state(), fault.state);
        rig.tamper = nullptr;
        rig.command = drive();
        rig.run_ms(3);
        EXPECT_EQ(rig.state(), fault.state); // latched
        EXPECT_EQ(rig.report.faults, fault.fault);
        rig.command = mode(usb::Mode::brake);
        rig.begin(true);
        rig.run_ms(40);
        EXPECT_EQ(rig.state(), State::braking);
        EXPECT_EQ(rig.faults(), 0);
    }
}

TEST(BoardFaults, ValuesWithinTheLimitsAreNone) {
    DrivingRig rig;
    rig.tamper = [](Samples &s) {
        s.supply_V = 13.01F;
        s.temperature_C[0] = 84.9F;
        s.temperature_C[1] = 200.0F; // not a sensor of this board
    };
    rig.run_ms(10);
    rig.tamper = [](Samples &s) { s.supply_V = 17.99F; };
    rig.run_ms(10);
    EXPECT_EQ(rig.state(), State::driving);
}

TEST(BoardFaults, ASpikeOfCurrentIsNone) {
    DrivingRig rig;
    int loops = 0;
    rig.tamper = [&](Samples &s) {
        if (++loops % 10 < 2) {
            s.current_A[0] = 7.0F;
        }
    };
    rig.run_ms(5);
    EXPECT_EQ(rig.faults() & Faults::kOverCurrent, 0);
}

TEST(BoardFaults, CurrentThatBrakingDoesNotEndOpens) {
    DrivingRig rig;
    rig.tamper = [](Samples &s) { s.current_A[0] = 7.0F; };
    rig.run_ms(4);
    EXPECT_EQ(rig.state(), State::fault_braking);
    rig.run_ms(2);
    EXPECT_EQ(rig.state(), State::fault_open);
    EXPECT_EQ(rig.faults(), Faults::kOverCurrent | Faults::kAmplifier);
}

TEST(BoardFaults, AnImpossibleJumpOfAnEncoder) {
    for (const int jump : {64, 65}) {
        DrivingRig rig;
        bool has_jumped = false;
        rig.tamper = [&](Samples &s) {
            s.encoder[1] = static_cast<std::uint16_t>(s.encoder[1] + jump);
            has_jumped = true;
        };
        rig.run_ms(1);
        EXPECT_EQ(rig.faults(), jump > 64 ? Faults::kEncoder : 0);
        EXPECT_EQ(rig.state(), jump > 64 ? State::fault_braking : State::driving);
        EXPECT_TRUE(has_jumped);
    }
}

TEST(BoardFaults, ALoopThatIsMuchTooLate) {
    for (const std::uint32_t pause_us : {50U, 80U}) { // besides its period of 25 µs
        DrivingRig rig;
        rig.run_loops(4);
        rig.pass_time_us(pause_us);
        rig.run_loops(1);
        EXPECT_EQ(rig.state(), pause_us > 75 ? State::fault_braking : State::driving);
        EXPECT_EQ(rig.faults(), pause_us > 75 ? Faults::kOverrun : 0);
    }
}

/// Nothing else notices: no time-out elapses, no report is due, and windings do not warm. Checks
/// come every 16 loops, and the second one after it stood still finds it.
TEST(BoardFaults, ATimerThatStandsStillOrIsSlow) {
    constexpr int kLoops = 2 * 16;
    for (const double pace : {0.0, 0.5, 0.87, 0.9, 1.0}) {
        for (const int offset : {0, 5, 11, 15}) {
            DrivingRig rig;
            rig.run_loops(offset);
            const std::uint32_t from_us = rig.now_us();
            rig.tamper = [&](Samples &s) {
                s.time_us = from_us + static_cast<std::uint32_t>(pace * (s.time_us - from_us));
            };
            rig.run_loops(kLoops);
            EXPECT_EQ(rig.state(), pace < 0.875 ? State::fault_braking : State::driving) << pace;
            EXPECT_EQ(rig.faults(), pace < 0.875 ? Faults::kOverrun : 0) << pace;
            if (pace == 0.0) {
                rig.begin(true);
                rig.run_loops(kLoops);
                EXPECT_EQ(rig.state(), State::fault_braking); // not while it stands still
                rig.host_sends = false;
                rig.tamper = nullptr;
                rig.run_loops(kLoops);
                rig.begin(true);
                rig.run_loops(1);
                EXPECT_EQ(rig.state(), State::braking);
            }
        }
    }
}

/// A host that ignores what windings may have been before power-up, and one that waits.
TEST(BoardFaults, AfterPowerUpWindingsMayBeHot) {
    for (const double idle_s : {0.1, 20.0}) {
        BoardRig rig;
        rig.start();
        rig.run_ms(static_cast<int>(1e3 * idle_s));
        EXPECT_EQ(rig.faults(), 0);
        rig.command = drive(0.55F, 1.68F); // 1.1 A: for ever
        rig.run_ms(2000);
        EXPECT_EQ(rig.state(), State::driving);
        rig.command = drive(2.0F, 1.68F); // 4 A
        int held_ms = 0;
        for (; rig.state() == State::driving && held_ms < 5000; held_ms += 10) {
            rig.run_ms(10);
        }
        EXPECT_EQ(rig.faults(), Faults::kHeat);
        // 4² · 3.08 Ω into 3.9 J/K are 12.7 K/s less what the housing takes; after 20 s 8 K are
        // left below the limit.
        EXPECT_LT(held_ms, idle_s < 1.0 ? 150 : 1200);
        EXPECT_GT(held_ms, idle_s < 1.0 ? 0 : 400);
    }
}

TEST(BoardFaults, AHeldContactTripsBeforeTheWindingIsTooHot) {
    DrivingRig rig;
    rig.command = drive(2.5F, 1.68F); // 5 A, the resistance of a winding that stays cold
    int loops_ms = 0;
    while (rig.state() == State::driving && loops_ms < 20'000) {
        rig.run_ms(10);
        loops_ms += 10;
    }
    EXPECT_EQ(rig.faults(), Faults::kHeat);
    EXPECT_GT(loops_ms, 3000);
    EXPECT_LT(loops_ms, 6000);
}

/// Whatever arrives: duty ratios stay finite and within their limit, at every loop.
TEST(BoardFaults, NothingThatIsNotFiniteReachesTheBridge) {
    std::mt19937 random(7);
    const auto any_float = [&] {
        return std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    };
    const auto is_safe = [](const BridgeOrder &order) {
        return std::all_of(order.duty_ratio.begin(), order.duty_ratio.end(),
                           [](float duty) { return std::abs(duty) <= 0.95F; }); // not for NaN
    };
    int driven = 0;
    for (int trial = 0; trial < 300; ++trial) {
        DrivingRig rig;
        rig.tamper = [&](Samples &s) {
            switch (trial % 4) {
            case 0:
                s.current_A[random() % 3] = any_float();
                break;
            case 1:
                s.supply_V = any_float();
                break;
            case 2:
                s.current_A = {6.0F, -6.0F, std::numeric_limits<float>::denorm_min()};
                break;
            default:
                s.time_us = static_cast<std::uint32_t>(random());
                s.encoder[0] = static_cast<std::uint16_t>(random());
                break;
            }
        };
        for (int loop = 0; loop < 40; ++loop) {
            usb::Command command = drive();
            command.e_W_V[random() % 3] = any_float();
            command.cancelled_resistance_Ohm.off_diagonal[random() % 3] = any_float();
            command.cancelled_inductance_H.diagonal[random() % 3] = any_float() * 1e-3F;
            (void)rig.send(command);
            rig.run_loops(1);
            ASSERT_TRUE(is_safe(rig.order));
            driven += rig.order.stage[0] == Stage::drive ? 1 : 0;
        }
    }
    EXPECT_GT(driven, 300); // not vacuous
}

bool order(BoardRig &rig, float voltage_V = 0.5F, std::uint32_t pulse_us = 8000) {
    return rig.request(usb::Kind::self_test, usb::SelfTestOrder{voltage_V, pulse_us});
}

usb::SelfTestResult result(BoardRig &rig) {
    return rig.ask<usb::SelfTestResult>(usb::Kind::self_test);
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
    EXPECT_FALSE(order(rig, 2.001F));
    EXPECT_FALSE(order(rig, 0.5F, 20'001));
    EXPECT_FALSE(order(rig, 0.5F, 7999)); // 319 loops
    EXPECT_TRUE(order(rig, 2.0F, 20'000));
    rig.run_ms(1);
    EXPECT_FALSE(order(rig)); // testing
}

} // namespace
} // namespace springdrive::board
