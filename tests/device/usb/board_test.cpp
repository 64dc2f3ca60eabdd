// Covers device/usb/board/loop.{h,cpp}, link.{h,cpp} and board.h, with
// tests/device/usb/board_rig.h; for their faults see board_faults_test.cpp.
#include "device/usb/board/board.h"
#include "tests/device/usb/board_rig.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
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
using usb::Faults;
using usb::FrameStatus;

TEST(Board, MeasuresOffsetsWhileOpenThenBrakes) {
    BoardRig rig;
    rig.motor[0].sensor_offset_A = 0.05;
    rig.motor[2].sensor_offset_A = -0.08;
    rig.run_ms(10);
    EXPECT_EQ(rig.state(), State::starting);
    EXPECT_TRUE(all_stages(rig.order, Stage::open));
    rig.run_ms(30);
    EXPECT_EQ(rig.state(), State::braking);
    EXPECT_TRUE(all_stages(rig.order, Stage::brake));
    for (const float current_A : rig.report.current_A) {
        EXPECT_NEAR(current_A, 0.0, 5e-6); // a sum of 1024 floats
    }
}

TEST(Board, RefusesToStartWithAnImplausibleSensor) {
    BoardRig rig;
    rig.motor[1].sensor_offset_A = 0.11;
    rig.run_ms(40);
    EXPECT_EQ(rig.state(), State::fault_open);
    EXPECT_EQ(rig.faults(), Faults::kSensor);
}

TEST(Board, DrivesToTheSettledCurrentOfTheResidualResistance) {
    DrivingRig rig;
    rig.run_ms(20);
    EXPECT_NEAR(rig.current_A(0), 0.2 / (2.18 - 1.68), 1e-3 * 0.4);
    EXPECT_NEAR(rig.current_A(1), -0.2 / 0.5, 1e-3 * 0.4);
    EXPECT_EQ(rig.report.state, State::driving);
    EXPECT_NEAR(rig.report.current_A[0], rig.current_A(0), 1e-4);
    EXPECT_EQ(rig.report.supply_V, 15.0F);
    EXPECT_TRUE(rig.report.has_command);
    EXPECT_LE(rig.report.applied_after_us, 50);
}

TEST(Board, CouplesChannels) {
    DrivingRig rig;
    rig.command.cancelled_resistance_Ohm = {{1.6F, 1.5F, 1.4F}, {0.2F, -0.1F, 0.15F}};
    rig.run_ms(20);
    // (R − R̂) i = e_W, each row.
    const auto &o = rig.command.cancelled_resistance_Ohm.off_diagonal;
    const auto &d = rig.command.cancelled_resistance_Ohm.diagonal;
    const auto i = [&](std::size_t channel) { return rig.current_A(channel); };
    const double row_0 = (2.18 - d[0]) * i(0) - o[0] * i(1) - o[1] * i(2);
    const double row_1 = -o[0] * i(0) + (2.18 - d[1]) * i(1) - o[2] * i(2);
    const double row_2 = -o[1] * i(0) - o[2] * i(1) + (2.18 - d[2]) * i(2);
    EXPECT_NEAR(row_0, rig.command.e_W_V[0], 1e-4);
    EXPECT_NEAR(row_1, rig.command.e_W_V[1], 1e-4);
    EXPECT_NEAR(row_2, rig.command.e_W_V[2], 1e-4);
}

TEST(Board, ObeysModes) {
    DrivingRig rig;
    rig.command = mode(usb::Mode::brake);
    rig.run_ms(1);
    EXPECT_TRUE(all_stages(rig.order, Stage::brake));
    rig.command = mode(usb::Mode::open);
    rig.run_ms(1);
    EXPECT_TRUE(all_stages(rig.order, Stage::open));
    rig.command = drive(); // only after braking
    rig.run_ms(1);
    EXPECT_EQ(rig.state(), State::opened);
    EXPECT_EQ(rig.report.applied_after_us, usb::kNotApplied);
    rig.command = mode(usb::Mode::brake);
    rig.run_ms(1);
    rig.command = drive();
    rig.run_ms(1);
    EXPECT_EQ(rig.state(), State::driving);
}

TEST(BoardNumbering, NothingBeforeTheBeginningRepeatedOrOld) {
    BoardRig rig;
    rig.run_ms(40);
    EXPECT_EQ(rig.send(mode(usb::Mode::brake)), FrameStatus::stale);
    usb::Command command;
    command.begins_numbering = true;
    command.number = 0xfffffffeU;
    EXPECT_EQ(rig.send_as(command), FrameStatus::ok);
    command = drive();
    command.number = 0xfffffffeU;
    EXPECT_EQ(rig.send_as(command), FrameStatus::repeated);
    command.number = 1; // beyond the rollover; two were lost
    EXPECT_EQ(rig.send_as(command), FrameStatus::ok);
    command.number = 0;
    EXPECT_EQ(rig.send_as(command), FrameStatus::stale);
    command.number = 0x80000001U; // 2^31 further: before it
    EXPECT_EQ(rig.send_as(command), FrameStatus::stale);
    command.number = 0x80000000U;
    EXPECT_EQ(rig.send_as(command), FrameStatus::ok);
    rig.board().disconnect();
    command.number = 0x80000001U;
    EXPECT_EQ(rig.send_as(command), FrameStatus::stale);
}

TEST(BoardNumbering, CountsWhatItRejects) {
    DrivingRig rig;
    const std::uint16_t before = rig.report.rejected_frames;
    usb::Frame frame = usb::encode(drive());
    frame[20] ^= 1U;
    EXPECT_EQ(rig.board().receive(frame.data(), frame.size(), rig.now_us()),
              FrameStatus::wrong_crc);
    EXPECT_EQ(rig.board().receive(frame.data(), 63, rig.now_us()), FrameStatus::wrong_size);
    rig.run_ms(2);
    EXPECT_EQ(rig.report.rejected_frames, before + 2);
    EXPECT_EQ(rig.report.last_rejection, FrameStatus::wrong_size);
    const auto counters = rig.ask<usb::Counters>(usb::Kind::counters);
    EXPECT_EQ(counters.frames[static_cast<std::size_t>(FrameStatus::wrong_crc)], 1U);
    EXPECT_GT(counters.frames[0], 5U);
}

TEST(BoardWatchdog, BrakesBeyondItsPeriodAndNotBefore) {
    for (const std::uint16_t watchdog_us :
         {usb::kMinWatchdog_us, std::uint16_t{5000}, usb::kMaxWatchdog_us}) {
        DrivingRig rig;
        rig.host_sends = false;
        usb::Command last = drive();
        last.watchdog_us = watchdog_us;
        EXPECT_EQ(rig.send(last), FrameStatus::ok);
        // Loops at 0, 25 µs, … after its arrival: the one at watchdog_us is not yet beyond it.
        rig.run_loops(watchdog_us / 25 + 1);
        EXPECT_EQ(rig.state(), State::driving) << watchdog_us;
        rig.run_loops(1);
        EXPECT_EQ(rig.state(), State::fault_braking) << watchdog_us;
        EXPECT_TRUE(all_stages(rig.order, Stage::brake));
        EXPECT_EQ(rig.faults(), Faults::kNoCommand);
    }
}

TEST(BoardWatchdog, OnlyAcceptedCommandsFeedIt) {
    for (int kind = 0; kind < 4; ++kind) {
        DrivingRig rig;
        rig.host_sends = false;
        usb::Command command = drive();
        command.number = 101; // long ago
        for (int i = 0; i < 10; ++i) {
            if (kind == 0) {
                EXPECT_NE(rig.send_as(command), FrameStatus::ok);
            } else if (kind == 1) {
                usb::Command beyond = drive();
                beyond.e_W_V[0] = 13.0F;
                EXPECT_EQ(rig.send(beyond), FrameStatus::beyond_limits);
            } else if (kind == 2) {
                usb::Command bad = drive();
                bad.e_W_V[0] = kNotMeasured;
                EXPECT_EQ(rig.send(bad), FrameStatus::not_finite);
            }
            rig.run_ms(1);
        }
        EXPECT_EQ(rig.state(), State::fault_braking);
    }
}

TEST(BoardWatchdog, ADisconnectionBrakesAtOnce) {
    DrivingRig rig;
    rig.board().disconnect();
    rig.run_loops(1);
    EXPECT_EQ(rig.state(), State::fault_braking);
    rig.begin();
    rig.run_ms(1);
    EXPECT_EQ(rig.state(), State::fault_braking); // no resumption without a reset
    rig.begin(true);
    rig.run_ms(1);
    EXPECT_EQ(rig.state(), State::driving);
}

TEST(BoardWatchdog, HoldsAcrossTheRolloverOfTime) {
    DrivingRig rig(0U - 47'000U); // rolls over as it drives
    rig.run_ms(100);
    EXPECT_EQ(rig.state(), State::driving);
    EXPECT_LT(rig.now_us(), 200'000U);
    EXPECT_NEAR(rig.reports, 146, 2);
    EXPECT_LE(rig.report.applied_after_us, 50);
    rig.host_sends = false;
    rig.run_ms(6);
    EXPECT_EQ(rig.state(), State::fault_braking);
}

TEST(Board, DenormalCommandsAreObeyed) {
    DrivingRig rig;
    rig.command.e_W_V = {std::numeric_limits<float>::denorm_min(), -1e-40F, 0.0F};
    rig.run_ms(5);
    EXPECT_EQ(rig.last_status, FrameStatus::ok);
    EXPECT_EQ(rig.state(), State::driving);
    EXPECT_NEAR(rig.current_A(0), 0.0, 2e-5); // R̂/dR times the offset's rounding
}

TEST(Board, LimitsVoltageAndSaysSo) {
    DrivingRig rig;
    for (testing::RigMotor &motor : rig.motor) {
        motor.resistance_Ohm = 3.0; // hot: 12 V drive less than the peak
    }
    rig.command = drive(12.0F, 2.0F);
    rig.run_loops(30);
    EXPECT_NEAR(std::abs(rig.order.duty_ratio[0]), 12.0 / 15.0, 1e-4);
    rig.run_ms(1);
    EXPECT_NE(rig.report.limits, 0);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_LE(std::abs(rig.current_A(i)), 4.01);
    }
}

// With an R close to R̂, or below it until the board brakes, and rotors that run away from a load.
TEST(Board, KeepsThePeakWhateverTheHostCommands) {
    std::mt19937 random(5);
    const auto any = [&](float most) {
        return std::uniform_real_distribution<float>(-most, most)(random);
    };
    double highest_A = 0.0;
    for (int trial = 0; trial < 20; ++trial) {
        DrivingRig rig;
        for (testing::RigMotor &motor : rig.motor) {
            motor.resistance_Ohm = trial % 2 == 0 ? 2.3 : 1.95;
            motor.is_held = false;
        }
        for (int ms = 0; ms < 40; ++ms) {
            rig.command = drive(any(12.0F), 2.28F);
            for (testing::RigMotor &motor : rig.motor) { // at most 2 m/s of the tip
                motor.rate_rad_per_s = std::clamp(motor.rate_rad_per_s, -190.0, 190.0);
            }
            for (int loop = 0; loop < 40; ++loop) {
                rig.run_loops(1);
                for (std::size_t i = 0; i < 3; ++i) {
                    highest_A = std::max(highest_A, std::abs(rig.current_A(i)));
                }
            }
        }
        EXPECT_TRUE(rig.faults() == 0 || (trial % 2 == 1 && rig.faults() == Faults::kGenerating));
    }
    EXPECT_LE(highest_A, 5.5);
    EXPECT_GT(highest_A, 5.4);
}

TEST(BoardReports, OneInEachPeriodOfTheHostInItsPhase) {
    DrivingRig rig;
    rig.command.report_after_us = 800;
    rig.run_ms(3);
    const int before = rig.reports;
    std::uint32_t number = rig.report.number;
    for (int i = 0; i < 50; ++i) {
        rig.run_ms(1);
        EXPECT_EQ(rig.report.number, ++number);
        EXPECT_EQ(rig.report.measured_at_us - rig.report.command_arrived_at_us, 800U);
    }
    EXPECT_EQ(rig.reports - before, 50);
}

TEST(BoardReports, ContinueWithoutCommandsAndWithCommandsThatComeTooOften) {
    BoardRig rig;
    rig.run_ms(100);
    EXPECT_NEAR(rig.reports, 100, 1);
    rig.begin();
    usb::Command often;
    often.report_after_us = 800;
    const int before = rig.reports;
    for (int i = 0; i < 400; ++i) { // every quarter millisecond: none may put the report off again
        (void)rig.send(often);
        rig.run_loops(10);
    }
    EXPECT_GE(rig.reports - before, 100);
    EXPECT_LE(rig.reports - before, 126);
}

TEST(BoardReports, SayWhatWasReplacedAndLost) {
    BoardRig rig;
    usb::Frame frame;
    for (int i = 0; i < 400; ++i) { // ten milliseconds that nobody collects
        Samples samples;
        samples.time_us = static_cast<std::uint32_t>(25 * i);
        (void)rig.board().tick(samples);
    }
    EXPECT_TRUE(rig.board().take_report(frame));
    EXPECT_FALSE(rig.board().take_report(frame));
    usb::Report report;
    EXPECT_EQ(usb::decode(frame.data(), frame.size(), report), FrameStatus::ok);
    EXPECT_EQ(report.number, 10U);
}

TEST(BoardControl, DescribesItself) {
    BoardRig rig;
    rig.run_ms(40);
    auto board = rig.ask<usb::Capabilities>(usb::Kind::capabilities);
    EXPECT_EQ(board.loop_rate_hz, 40'000U);
    EXPECT_TRUE(board.couples_resistance && board.is_high_speed);
    EXPECT_NEAR(board.largest_cancelled_Ohm[0], 2.289, 1e-4);
    EXPECT_EQ(board.shortest_report_period_us, 125U);
    rig.board().set_speed(false);
    board = rig.ask<usb::Capabilities>(usb::Kind::capabilities);
    EXPECT_FALSE(board.is_high_speed);
    EXPECT_EQ(board.shortest_report_period_us, 1000U);
    EXPECT_FALSE(rig.request(usb::Kind::report_rate, usb::ReportRate{999})); // full speed
    EXPECT_TRUE(rig.request(usb::Kind::report_rate, usb::ReportRate{1000}));
    static_cast<void>(rig.ask<usb::Identity>(usb::Kind::identity));
    std::array<std::uint8_t, kMaxPayload> payload{};
    EXPECT_EQ(rig.board().control_in(0x77, 0, payload.data()), 0U);
    EXPECT_EQ(rig.board().control_in(static_cast<std::uint8_t>(usb::Kind::calibration),
                                     kCalibrationBlocks, payload.data()),
              0U);
}

TEST(BoardControl, ZeroesAtRestOnly) {
    BoardRig rig;
    rig.start();
    rig.motor[1].angle_rad = 1.0;
    rig.tamper = nullptr;
    EXPECT_TRUE(rig.request(usb::Kind::zero, usb::Zeroing{{10, -20, 30}}));
    rig.run_ms(2);
    EXPECT_EQ(rig.report.counts, (std::array<std::int32_t, 3>{10, -20, 30}));
    EXPECT_EQ(rig.report.zeroings, 2); // the rotor's leap was a fault, which counts as one
    rig.begin(true);
    rig.command = drive();
    rig.run_ms(2);
    EXPECT_EQ(rig.state(), State::driving);
    EXPECT_FALSE(rig.request(usb::Kind::zero, usb::Zeroing{}));
    rig.run_ms(2);
    EXPECT_EQ(rig.report.zeroings, 2);
}

TEST(BoardControl, StoresCalibrationAndUsesItsOwn) {
    BoardRig rig;
    rig.start();
    const usb::BoardCalibration calibration{{1.02F, 1.0F, 1.0F}, {2.0F, 0.0F, 0.0F}, {1, -1, 1}};
    EXPECT_TRUE(rig.request(usb::Kind::calibration, usb::block_of(calibration)));
    usb::CalibrationBlock own;
    own.index = 3;
    own.bytes[55] = 7;
    EXPECT_TRUE(rig.request(usb::Kind::calibration, own));
    usb::CalibrationBlock stored;
    EXPECT_TRUE(rig.board().take_block_to_store(stored));
    EXPECT_EQ(stored.index, 0);
    EXPECT_TRUE(rig.board().take_block_to_store(stored));
    EXPECT_EQ(stored.index, 3);
    EXPECT_FALSE(rig.board().take_block_to_store(stored));
    rig.run_ms(2);
    EXPECT_EQ(rig.report.zeroings, 1); // another sign: counts mean other angles
    stored = rig.ask<usb::CalibrationBlock>(usb::Kind::calibration, 3);
    EXPECT_EQ(stored.bytes, own.bytes);
    rig.run_ms(3);
    usb::Command command = drive();
    command.cancelled_resistance_Ohm.diagonal[0] = 2.01F;
    EXPECT_EQ(rig.send(command), FrameStatus::beyond_limits);

    rig.board().end_store(3, false); // a chip that failed
    std::array<std::uint8_t, kMaxPayload> payload{};
    const auto read_back = [&] {
        return rig.board().control_in(static_cast<std::uint8_t>(usb::Kind::calibration), 3,
                                      payload.data());
    };
    EXPECT_EQ(read_back(), 0U);
    EXPECT_TRUE(rig.request(usb::Kind::calibration, own));
    EXPECT_GT(read_back(), 0U);

    own.index = kCalibrationBlocks;
    EXPECT_FALSE(rig.request(usb::Kind::calibration, own));
    usb::BoardCalibration wrong = calibration;
    wrong.largest_cancelled_Ohm[1] = 4.0F; // raises the board's own limit too far
    EXPECT_FALSE(rig.request(usb::Kind::calibration, usb::block_of(wrong)));
}

/// A chip may halt while it stores: neither is a block stored while a motor can be driven, nor a
/// motor driven until it is stored. Whether the loop has seen the last command, or a report has
/// told of it, makes no difference.
TEST(BoardControl, StoresNothingWhileAMotorCanBeDriven) {
    usb::CalibrationBlock own;
    own.index = 3;
    usb::CalibrationBlock stored;
    for (const int loops : {0, 1, 40, 1999}) {
        BoardRig rig;
        rig.start();
        EXPECT_TRUE(rig.request(usb::Kind::report_rate, usb::ReportRate{50'000}));
        rig.run_ms(60);
        rig.host_sends = loops > 100;
        rig.command = drive();
        EXPECT_EQ(rig.send(drive()), FrameStatus::ok);
        rig.run_loops(loops); // no report yet
        EXPECT_FALSE(rig.request(usb::Kind::calibration, own)) << loops;
        EXPECT_FALSE(rig.board().take_block_to_store(stored));
        EXPECT_EQ(rig.state(), loops > 0 ? State::driving : State::braking);
        rig.host_sends = false;
        EXPECT_EQ(rig.send(mode(usb::Mode::brake)), FrameStatus::ok);
        EXPECT_EQ(rig.request(usb::Kind::calibration, own), loops == 0);
        rig.run_loops(1);
        EXPECT_EQ(rig.state(), State::braking);
        EXPECT_TRUE(rig.request(usb::Kind::calibration, own));
        EXPECT_TRUE(rig.board().take_block_to_store(stored));
        // As long as it is being stored, commands to drive are accepted, but not applied.
        for (int i = 0; i < 20; ++i) {
            EXPECT_EQ(rig.send(drive()), FrameStatus::ok);
            EXPECT_FALSE(rig.request(usb::Kind::self_test,
                                     usb::SelfTestOrder{.voltage_V = 0.5F, .pulse_us = 8000}));
            rig.run_loops(40);
            EXPECT_EQ(rig.state(), State::braking);
            EXPECT_TRUE(all_stages(rig.order, Stage::brake));
        }
        rig.board().end_store(stored.index, true);
        EXPECT_EQ(rig.send(drive()), FrameStatus::ok);
        rig.run_loops(1);
        EXPECT_EQ(rig.state(), State::driving);
    }
}

/// The same in any order of commands, requests and loops.
TEST(BoardControl, NeverStoresAndDrivesAtOnce) {
    std::mt19937 random(3);
    BoardRig rig;
    rig.start();
    rig.host_sends = false;
    usb::CalibrationBlock own;
    usb::CalibrationBlock stored;
    bool is_storing = false;
    int times_stored = 0;
    int times_driven = 0;
    for (int i = 0; i < 40'000; ++i) {
        switch (random() % 8) {
        case 0:
            (void)rig.send(drive());
            break;
        case 1:
            (void)rig.send(mode(usb::Mode::brake));
            break;
        case 2:
            own.index = static_cast<std::uint16_t>(1 + random() % 3);
            (void)rig.request(usb::Kind::calibration, own);
            break;
        case 3:
            (void)rig.request(usb::Kind::self_test,
                              usb::SelfTestOrder{.voltage_V = 0.5F, .pulse_us = 8000});
            break;
        case 4:
            if (is_storing) {
                rig.board().end_store(stored.index, random() % 2 == 0);
                is_storing = false;
            } else {
                is_storing = rig.board().take_block_to_store(stored);
                times_stored += is_storing ? 1 : 0;
            }
            break;
        case 5:
            rig.begin(true);
            break;
        default:
            rig.run_loops(1 + static_cast<int>(random() % 20));
            times_driven += rig.state() == State::driving ? 1 : 0;
            break;
        }
        ASSERT_FALSE(is_storing &&
                     (rig.state() == State::driving || rig.state() == State::testing));
    }
    EXPECT_GT(times_stored, 500);
    EXPECT_GT(times_driven, 300);
}

/// Random requests, half of them with a valid checksum, while the board drives.
TEST(BoardControl, RandomRequestsDoNoHarm) {
    std::mt19937 random(8);
    DrivingRig rig;
    std::array<std::uint8_t, kMaxPayload> reply{};
    for (int i = 0; i < 20'000; ++i) {
        std::vector<std::uint8_t> bytes(random() % 110);
        for (std::uint8_t &byte : bytes) {
            byte = static_cast<std::uint8_t>(random());
        }
        const auto request = static_cast<std::uint8_t>(random() % 64);
        if (bytes.size() > 6 && random() % 2 == 0) {
            bytes[0] = usb::kProtocolVersion;
            bytes[1] = request;
            const std::uint32_t crc = usb::crc32(bytes.data(), bytes.size() - 4);
            for (std::size_t j = 0; j < 4; ++j) {
                bytes[bytes.size() - 4 + j] = static_cast<std::uint8_t>(crc >> (8 * j));
            }
        }
        (void)rig.board().control_out(request, bytes.data(), bytes.size());
        EXPECT_LE(
            rig.board().control_in(request, static_cast<std::uint16_t>(random()), reply.data()),
            reply.size());
        if (i % 20 == 0) {
            rig.run_loops(1);
        }
    }
    rig.run_ms(20);
    EXPECT_EQ(rig.state(), State::driving);
    EXPECT_NEAR(rig.current_A(0), 0.4, 1e-3);
}

/// The least that a chip's port consists of.
class Chip {
public:
    Samples sample() {
        Samples samples;
        samples.time_us = time_us;
        samples.supply_V = 15.0F;
        samples.temperature_C[0] = 30.0F;
        time_us += 25;
        return samples;
    }
    void apply(const BridgeOrder &given) { order = given; }
    [[nodiscard]] std::uint32_t now_us() const { return time_us; }
    void kick_watchdog() { ++kicks; }
    static bool load_block(std::uint16_t index, usb::CalibrationBlock &block) {
        if (index == 2) {
            block.bytes[0] = 42;
        }
        return index == 2;
    }
    bool store_block(const usb::CalibrationBlock &block) {
        stored = block.index;
        return true;
    }

    std::uint32_t time_us = 0;
    BridgeOrder order;
    int kicks = 0;
    int stored = -1;
};

TEST(Hardware, RunsOnAChip) {
    static_assert(Hardware<Chip>);
    Chip chip;
    Board board({}, {});
    start(chip, board);
    EXPECT_TRUE(all_stages(chip.order, Stage::open));
    run_background(chip, board);
    EXPECT_EQ(chip.kicks, 0); // the loop has not run
    for (int i = 0; i < 1600; ++i) {
        run_loop(chip, board);
    }
    EXPECT_TRUE(all_stages(chip.order, Stage::brake));
    run_background(chip, board);
    run_background(chip, board);
    EXPECT_EQ(chip.kicks, 1);
    EXPECT_EQ(chip.stored, -1);
    std::array<std::uint8_t, kMaxPayload> payload{};
    const auto kind = static_cast<std::uint8_t>(usb::Kind::calibration);
    const std::size_t size = board.control_in(kind, 2, payload.data());
    EXPECT_EQ(payload[4], 42);
    EXPECT_TRUE(board.control_out(kind, payload.data(), size));
    run_background(chip, board);
    EXPECT_EQ(chip.stored, 2);
}

TEST(Board, AWrongSupplySensorRaisesNoVoltage) {
    for (const float read_V : {0.1F, -0.02F, 0.0F, 5.0F}) {
        BoardRig rig;
        rig.start();
        rig.command.mode = usb::Mode::drive;
        rig.command.e_W_V.fill(0.3F);
        rig.run_ms(5);
        ASSERT_EQ(rig.state(), State::driving);
        rig.tamper = [read_V](Samples &samples) { samples.supply_V = read_V; };
        for (int i = 0; i < 400; ++i) { // a fault by then
            rig.run_loops(1);
            // 0.3 V of a supply that is at least the smallest one, 13 V.
            ASSERT_LE(std::abs(rig.order.duty_ratio[0]), 0.3F / 13.0F * 1.001F) << read_V;
        }
        EXPECT_NE(rig.faults() & Faults::kSupply, 0) << read_V;
    }
}

} // namespace
} // namespace springdrive::board
