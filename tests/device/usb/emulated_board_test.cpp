// Covers device/usb/emulator/{emulated_board,emulated_plant,packet_line}: time, delay and packets
// against their definitions in PROTOCOL.md, and the plant. For faults see emulated_faults_test.cpp.
#include "base/input_error.h"
#include "device/usb/emulator/emulated_board.h"
#include "tests/device/usb/board_rig.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

namespace springdrive::emulator {
namespace {

using simulated::SimulatedPhantom;
using testing::ask;
using testing::driving;
using testing::emulated_options;
using testing::Host;
using testing::order;
using usb::BoardState;
using usb::Command;
using usb::Counters;
using usb::Faults;
using usb::FrameStatus;
using usb::Kind;
using usb::Report;

constexpr double kServo_s = 1e-3;

// Time.

TEST(FrameClock, MovesByOneReportForEachPacket) {
    Host host;
    usb::Frame frame;
    EXPECT_EQ(host.board.take(frame), 0U); // not attached
    EXPECT_EQ(host.state(), BoardState::braking);
    const double began_s = host.board.time_s();
    host.board.attach(true);
    ASSERT_TRUE(host.receive());
    EXPECT_FALSE(host.receive());
    std::uint32_t last_us = host.report.measured_at_us;
    for (int i = 0; i < 20; ++i) {
        Command command;
        command.begins_numbering = i % 3 == 0;
        host.send(command);
        if (i % 4 == 3) { // a packet that is rejected counts, too
            host.board.put(std::array<std::uint8_t, 3>{1, 2, 3});
            ASSERT_TRUE(host.receive());
            last_us += 1000;
        }
        ASSERT_TRUE(host.receive());
        EXPECT_EQ(host.report.measured_at_us, last_us + 1000);
        last_us = host.report.measured_at_us;
        EXPECT_FALSE(host.receive());
    }
    EXPECT_EQ(host.report.rejected_frames, 5);
    EXPECT_NEAR(host.board.time_s() - began_s, 0.026, 1e-3);
}

TEST(FrameClock, PassesWithoutDriftAndModulo32Bits) {
    for (const std::uint32_t rate_hz : {40'000U, 60'000U, 30'011U}) {
        EmulatedBoardOptions with = emulated_options();
        with.settings.loop_rate_hz = rate_hz;
        with.start_us = 0xffffffffU - 100'000U;
        Host host(with);
        host.begin();
        const double loop_us = 1e6 / rate_hz;
        host.receive();
        const std::uint32_t first_us = host.report.measured_at_us;
        for (int i = 1; i <= 300; ++i) {
            host.send({});
            ASSERT_TRUE(host.receive());
            ASSERT_NEAR(usb::difference(host.report.measured_at_us, first_us), 1000.0 * i, loop_us);
        }
        const double time_us = 1e6 * host.board.time_s();
        EXPECT_NEAR(host.board.plant().now_us() - with.start_us, time_us, 1.0) << rate_hz;
        EXPECT_LT(host.report.measured_at_us, first_us); // it began again at 0
        EXPECT_EQ(ask<Counters>(host.board, Kind::counters).late_loops, 0U);
    }
}

TEST(FrameClock, ImposesTheDelayToWithinALoop) {
    for (const std::uint32_t rate_hz : {40'000U, 60'000U}) {
        for (const std::uint32_t period_us : {500U, 1000U}) {
            for (const double d : {0.1, 0.3, 1.0, 1.7, 2.4, 8.0}) {
                EmulatedBoardOptions with = emulated_options();
                with.settings.loop_rate_hz = rate_hz;
                with.delay_periods = d;
                Host host(with);
                ASSERT_TRUE(order(host.board, Kind::report_rate, usb::ReportRate{period_us}));
                host.begin();
                int measured = 0;
                for (int i = 0; i < 60; ++i) {
                    ASSERT_TRUE(host.exchange(driving({0.1, 0.1, 0.1})));
                    if (i > 20) {
                        ++measured;
                        EXPECT_NEAR(host.delay_s(), 1e-6 * d * period_us, 1.0 / rate_hz)
                            << d << " at " << rate_hz << " Hz";
                    }
                }
                EXPECT_GT(measured, 30);
                EXPECT_EQ(host.report.rejected_frames, 0);
                EXPECT_EQ(host.state(), BoardState::driving);
            }
        }
    }
}

TEST(FrameClock, KeepsTheOrderOfPacketsWhenThePeriodChanges) {
    EmulatedBoardOptions with = emulated_options();
    with.delay_periods = 4.0;
    Host host(with);
    host.begin(8);
    host.exchange(driving({0.1, 0.1, 0.1}), 10);
    ASSERT_TRUE(order(host.board, Kind::report_rate, usb::ReportRate{250}));
    host.exchange(driving({0.1, 0.1, 0.1}), 60);
    EXPECT_EQ(host.report.rejected_frames, 0);
    EXPECT_NEAR(host.delay_s(), 1e-3, 25e-6);
}

TEST(FrameClock, NamesItsLeastDelay) {
    EmulatedBoardOptions with = emulated_options();
    with.delay_periods = 0.0;
    Host host(with);
    host.begin();
    host.exchange(driving({0.1, 0.1, 0.1}), 5);
    EXPECT_NEAR(host.delay_s(), host.board.min_delay_periods() * kServo_s, 2e-6);
    EXPECT_DOUBLE_EQ(host.board.min_delay_periods(), 1.5 * 25e-6 / kServo_s);
}

TEST(FrameClock, LetsTimePassForASilentHost) {
    Host host;
    host.begin();
    host.exchange(driving({0.1, 0.1, 0.1}), 10);
    ASSERT_TRUE(host.receive());
    const double stopped_s = host.board.time_s();
    host.pass_ms(99);
    EXPECT_EQ(host.board.time_s(), stopped_s);
    EXPECT_FALSE(host.receive());
    EXPECT_EQ(host.state(), BoardState::driving);
    // The watchdog of 5 ms began when the last command arrived, most of a period ago.
    host.pass_ms(5);
    EXPECT_EQ(host.state(), BoardState::driving);
    host.pass_ms(2);
    EXPECT_EQ(host.state(), BoardState::fault_braking);
    EXPECT_EQ(host.faults(), Faults::kNoCommand);
    ASSERT_TRUE(host.receive()); // one for each tenth of a second
    EXPECT_FALSE(host.receive());
    // And by packets again, one report each; the first has had its own.
    const double silent_s = host.board.time_s();
    EXPECT_NEAR(silent_s - stopped_s, 6e-3, 1e-4);
    host.send({});
    EXPECT_FALSE(host.receive());
    host.send({});
    ASSERT_TRUE(host.receive());
    EXPECT_EQ(host.report.faults, Faults::kNoCommand);
    EXPECT_FALSE(host.receive());
    host.pass_ms(50);
    EXPECT_LE(host.board.time_s() - silent_s, 1.1e-3);
}

// A host that is slow now and then: what it was offered meanwhile waits to be read.
TEST(FrameClock, KeepsTheDelayOfAHostThatWasSilentForAWhile) {
    for (const int silent_ms : {0, 90, 110, 350}) {
        SCOPED_TRACE(silent_ms);
        Host host;
        host.begin();
        host.exchange({}, 20);
        const double before_s = host.delay_s();
        ASSERT_TRUE(host.receive());
        std::vector<Report> read; // not answered yet
        for (int i = 0; i < silent_ms; ++i) {
            host.board.pass(1e-3);
            const Report last = host.report;
            if (host.receive()) {
                read.push_back(host.report);
            }
            host.report = last;
        }
        EXPECT_EQ(static_cast<int>(read.size()), silent_ms / 100);
        // It answers them one after the other, each with what came in between.
        for (int i = 0; i < 20; ++i) {
            host.send({});
            if (host.receive()) {
                read.push_back(host.report);
            }
            ASSERT_FALSE(read.empty());
            host.report = read.front();
            read.erase(read.begin());
        }
        EXPECT_TRUE(read.empty());
        EXPECT_NEAR(host.delay_s(), before_s, 1e-6); // of the board's time, in whole µs
    }
}

/// Reports with the times at which they are measured.
std::string wall_clock_run(const std::vector<double> &pieces_s, double total_s) {
    EmulatedBoardOptions with = emulated_options();
    with.clock = BoardClock::wall;
    Host host(with);
    host.board.attach(true);
    std::string text;
    double passed_s = 0.0;
    std::size_t next = 0;
    while (passed_s < total_s) {
        const double piece_s = std::min(pieces_s[next++ % pieces_s.size()], total_s - passed_s);
        host.board.pass(piece_s);
        passed_s += piece_s;
        if (host.receive()) {
            text += std::to_string(host.report.number) + "@" +
                    std::to_string(host.report.measured_at_us) + ":" +
                    std::to_string(host.report.counts[0]) + "/" +
                    std::to_string(host.report.current_A[1]) + " ";
        }
    }
    EXPECT_EQ(host.board.late_s(), 0.0);
    return text;
}

TEST(WallClock, DoesNotDependOnHowItIsCut) {
    const double total_s = 0.05001;
    const std::string reference = wall_clock_run({1e-4}, total_s);
    EXPECT_GT(reference.size(), 1000U);
    EXPECT_EQ(wall_clock_run({3.3e-6}, total_s), reference);
    EXPECT_EQ(wall_clock_run({7.7e-4, 1e-5, 0.0, 3.1e-4}, total_s), reference);
}

TEST(WallClock, FallsBehindRatherThanCatchesUp) {
    EmulatedBoardOptions with = emulated_options();
    with.clock = BoardClock::wall;
    Host host(with);
    host.board.attach(true);
    const double began_s = host.board.time_s();
    host.board.pass(0.25);
    EXPECT_NEAR(host.board.late_s(), 0.25 - EmulatedBoard::kMaxStep_s, 1e-9);
    EXPECT_NEAR(host.board.time_s() - began_s, EmulatedBoard::kMaxStep_s, 1e-9);
    host.receive();
    EXPECT_FALSE(host.receive()); // the others were replaced
    host.board.pass(std::nan(""));
    host.board.pass(-1.0);
    EXPECT_NEAR(host.board.time_s() - began_s, EmulatedBoard::kMaxStep_s, 1e-9);
}

TEST(WallClock, TakesPacketsWhenTheyArePut) {
    EmulatedBoardOptions with = emulated_options();
    with.clock = BoardClock::wall;
    Host host(with);
    host.board.attach(true);
    Command command;
    command.begins_numbering = true;
    double expected_s = 0.0;
    for (int i = 0; i < 10; ++i) {
        EXPECT_TRUE(host.receive() || i == 0);
        EXPECT_TRUE(i < 3 || std::abs(host.delay_s() - expected_s) <= 1e-6) << host.delay_s();
        host.board.pass(0.3e-3);
        // Seen by the next loop, and applied half a loop after it.
        const std::uint32_t put_us = host.board.plant().now_us();
        expected_s = 1e-6 * (usb::difference(put_us, host.report.measured_at_us) + 25 + 12);
        host.send(i == 0 ? command : driving({0.1, 0.1, 0.1}));
        host.board.pass(0.7e-3);
    }
    EXPECT_EQ(host.state(), BoardState::driving);
}

// The plant.

/// A plant without a board.
EmulatedPlant bare_plant(std::uint32_t start_us = 0) {
    return {
        testing::phantom_1_0(), {}, emulated_options().simulation, testing::kOffCentre_m, start_us};
}

TEST(EmulatedPlant, AppliesVoltagesHalfALoopAfterTheSamples) {
    EmulatedPlant plant = bare_plant();
    board::BridgeOrder drive;
    drive.stage.fill(board::Stage::drive);
    drive.duty_ratio = {0.02F, -0.02F, 0.04F};
    plant.apply(board::BridgeOrder::braking());
    static_cast<void>(plant.sample());
    plant.apply(drive);
    const Vector3 before_A = plant.phantom().truth().current_A; // from its fall in the first loop
    const double time_s = 0.238e-3 / 2.18;
    for (const double loops : {0.5, 1.5, 2.5}) {
        const board::Samples samples = plant.sample();
        for (std::size_t i = 0; i < 3; ++i) {
            const double settled_A = 15.0 * static_cast<double>(drive.duty_ratio[i]) / 2.18;
            const double expected_A = settled_A * (1.0 - std::exp(-loops * 25e-6 / time_s)) +
                                      before_A[static_cast<Eigen::Index>(i)];
            // The winding's ripple of 2 %, and the rotors that begin to turn.
            EXPECT_NEAR(static_cast<double>(samples.current_A[i]), expected_A,
                        0.03 * std::abs(settled_A))
                << loops;
        }
    }
}

TEST(EmulatedPlant, OpensSomeStagesWhileOthersDrive) {
    const auto current_of = [](board::Stage others) {
        EmulatedPlant plant = bare_plant();
        plant.phantom().set_in_motion({1.0, 1.0, -1.0}, {0.3, 0.3, 0.3});
        board::BridgeOrder order;
        order.stage = {board::Stage::drive, others, others};
        double largest_A = 0.0;
        for (int loop = 0; loop < 100; ++loop) {
            plant.apply(order);
            const board::Samples samples = plant.sample();
            if (loop > 40) { // nine time constants
                largest_A =
                    std::max({largest_A, std::abs(static_cast<double>(samples.current_A[1])),
                              std::abs(static_cast<double>(samples.current_A[2]))});
            }
        }
        return largest_A;
    };
    EXPECT_GT(current_of(board::Stage::brake), 0.05);
    EXPECT_LT(current_of(board::Stage::open), 5e-3);
}

/// Where no rotor turns, the bridge's voltage is R i + V_b tanh(i/i_b).
TEST(EmulatedPlant, HasBrushesAndBridgesWithTheSignOfTheCurrent) {
    simulated::SimulationOptions simulation = emulated_options().simulation;
    simulation.hand = {1e6, 1e6, 1e9, 1e9, 1.0};
    simulation.brush_voltage_V = 0.2;
    simulation.brush_current_A = 0.05;
    EmulatedPlant plant(testing::phantom_1_0(), {}, simulation, testing::kOffCentre_m, 0);
    board::BridgeOrder drive;
    drive.stage.fill(board::Stage::drive);
    drive.duty_ratio = {0.005F, -0.02F, 0.04F};
    for (int loop = 0; loop < 200; ++loop) { // 5 ms; L/R is 0.1 ms
        plant.apply(drive);
        static_cast<void>(plant.sample());
    }
    const simulated::SimulatedPhantom::Truth &truth = plant.phantom().truth();
    for (Eigen::Index i = 0; i < 3; ++i) {
        const double e_A_V =
            15.0 * static_cast<double>(drive.duty_ratio[static_cast<std::size_t>(i)]);
        EXPECT_NEAR(truth.resistance_Ohm[i] * truth.current_A[i] +
                        0.2 * std::tanh(truth.current_A[i] / 0.05),
                    e_A_V, 1e-5); // the hand yields by 1 µm per kN
    }
}

TEST(EmulatedPlant, LosesCountsAndTimeInARestart) {
    EmulatedPlant plant = bare_plant(1'000'000);
    plant.phantom().set_in_motion({1.0, 1.0, -1.0}, Vector3::Zero());
    board::Samples samples;
    for (int loop = 0; loop < 400; ++loop) {
        plant.apply(board::BridgeOrder::opening());
        samples = plant.sample();
    }
    EXPECT_EQ(samples.time_us, 1'010'000U);
    EXPECT_NE(samples.encoder, (std::array<std::uint16_t, 3>{}));
    EXPECT_GT(samples.encoder[2], 0x8000U); // counts modulo 2^16
    plant.restart();
    samples = plant.sample();
    EXPECT_EQ(samples.time_us, 1'000'025U);
    EXPECT_EQ(samples.encoder, (std::array<std::uint16_t, 3>{}));
}

std::array<std::int32_t, 3> counts_of(const SimulatedPhantom &device) {
    std::array<std::int32_t, 3> counts{};
    for (std::size_t j = 0; j < 3; ++j) {
        counts[j] = static_cast<std::int32_t>(
            std::lround(device.truth().theta_rad[static_cast<Eigen::Index>(j)] /
                        device.description().rad_per_count()));
    }
    return counts;
}

TEST(EmulatedPlant, CountsFromPowerUp) {
    Host host;
    const SimulatedPhantom unmoved(testing::phantom_1_0(), emulated_options().simulation,
                                   testing::kOffCentre_m);
    const auto at_power_up = counts_of(unmoved);
    host.begin();
    host.receive();
    const auto now = counts_of(host.board.phantom());
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(host.report.counts[i], now[i] - at_power_up[i], 1) << i;
    }
    EXPECT_GT(std::abs(at_power_up[1]), 100);
    EXPECT_FLOAT_EQ(host.report.supply_V, usb::truncated(15.0F));
    EXPECT_FLOAT_EQ(host.report.temperature_C[0], 30.0F);
    EXPECT_FALSE(host.report.is_stopped);
    EXPECT_TRUE(host.report.is_enabled);
}

TEST(EmulatedPlant, KeepsACalibrationThroughARestart) {
    Host host;
    host.begin();
    usb::BoardCalibration calibration;
    calibration.encoder_sign = {-1, 1, -1};
    ASSERT_TRUE(order(host.board, Kind::calibration, usb::block_of(calibration)));
    host.board.set_fault({.kind = device::FaultKind::restart});
    host.exchange({}, 5);
    const auto block = ask<usb::CalibrationBlock>(host.board, Kind::calibration);
    usb::BoardCalibration kept;
    ASSERT_EQ(usb::calibration_in(block, kept), FrameStatus::ok);
    EXPECT_EQ(kept.encoder_sign, calibration.encoder_sign);
}

TEST(EmulatedPlant, RefusesWhatABoardCannotHave) {
    EmulatedBoardOptions with = emulated_options();
    const auto error = [&] {
        return error_text_of([&] { EmulatedBoard(testing::phantom_1_0(), with); });
    };
    EXPECT_EQ(error(), "");
    with.simulation.dynamics = simulated::PlantDynamics::rigid_body;
    EXPECT_NE(error().find("choose electromechanical"), std::string::npos);
    with = emulated_options();
    with.settings.counts_per_turn[1] = 2000;
    EXPECT_NE(error().find("2000 counts"), std::string::npos);
    with = emulated_options();
    with.delay_periods = 8.5;
    EXPECT_NE(error().find("8.5 periods"), std::string::npos);
    EXPECT_NE(error_text_of([] { static_cast<void>(emulated_identity("a serial number")); }), "");
    EXPECT_EQ(error_text_of([] { static_cast<void>(emulated_identity("0123456789abcdef")); }), "");
}

TEST(EmulatedBoard, BrakesAtOnceWhenUnplugged) {
    Host host;
    host.begin();
    host.exchange(driving({0.3, 0.3, 0.3}), 20);
    EXPECT_EQ(host.state(), BoardState::driving);
    host.board.detach();
    host.board.pass(30e-6); // one loop
    EXPECT_EQ(host.state(), BoardState::fault_braking);
    EXPECT_EQ(host.faults(), Faults::kNoCommand);
    host.pass_ms(20);
    EXPECT_FALSE(host.receive());
    // Packets of before are lost, and nothing is numbered.
    host.board.attach(true);
    host.exchange(driving({0.3, 0.3, 0.3}), 3);
    EXPECT_EQ(host.report.last_rejection, FrameStatus::stale);
    EXPECT_EQ(host.state(), BoardState::fault_braking);
}

TEST(EmulatedBoard, LosesWhatIsUnderWayWhenUnplugged) {
    EmulatedBoardOptions with = emulated_options();
    with.delay_periods = 4.0;
    with.faults.push_back(device::parse_fault("delay:in:#3:4"));
    Host host(with);
    host.begin(3); // none has arrived yet, and the third report has not been handed out
    EXPECT_EQ(ask<Counters>(host.board, Kind::counters).frames[0], 0U);
    host.board.detach();
    host.pass_ms(20);
    EXPECT_EQ(ask<Counters>(host.board, Kind::counters).frames[0], 0U);
    const std::uint32_t before_us = host.board.plant().now_us();
    host.board.attach(true);
    ASSERT_TRUE(host.receive());
    EXPECT_GT(host.report.measured_at_us, before_us);
}

TEST(EmulatedBoard, IsTheSameForTheSameSeed) {
    const auto run = [](std::uint64_t seed) {
        EmulatedBoardOptions with = emulated_options();
        with.seed = seed;
        with.simulation.device_seed = 3; // noisy sensors
        with.simulation.effects.coulomb_friction = true;
        with.delay_periods = 1.3;
        for (const char *fault : {"drop:in:0.1", "corrupt:out:0.1", "delay:out:0.2:2"}) {
            with.faults.push_back(device::parse_fault(fault));
        }
        Host host(with);
        host.begin(5);
        std::vector<usb::Frame> frames;
        for (int i = 0; i < 100; ++i) {
            host.exchange(driving({0.2, 0.1, -0.1}));
            frames.push_back(usb::encode(host.report));
        }
        return frames;
    };
    EXPECT_EQ(run(4), run(4));
    EXPECT_NE(run(4), run(5));
}

} // namespace
} // namespace springdrive::emulator
