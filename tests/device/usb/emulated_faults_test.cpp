// Covers what device/core/faults do to an emulated board and its link, each with and without.
#include "device/usb/emulator/emulated_board.h"
#include "tests/device/usb/board_rig.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

namespace springdrive::emulator {
namespace {

using testing::ask;
using testing::driving;
using testing::emulated_options;
using testing::Host;
using testing::order;
using usb::BoardState;
using usb::ChannelFindings;
using usb::Command;
using usb::Counters;
using usb::Faults;
using usb::FrameStatus;
using usb::Kind;
using usb::Report;

/// @param fault  in words; empty for none
EmulatedBoardOptions with_fault(const std::string &fault) {
    EmulatedBoardOptions with = emulated_options();
    if (!fault.empty()) {
        with.faults.push_back(device::parse_fault(fault));
    }
    return with;
}

// Faults of the link.

/// Twenty packets with one fault, by a host that brakes.
struct LinkRun {
    Counters counters;
    std::vector<FrameStatus> statuses;  ///< of what was taken
    std::vector<std::uint32_t> numbers; ///< of valid reports
    std::uint64_t strikes = 0;

    [[nodiscard]] std::uint32_t commands(FrameStatus status) const {
        return counters.frames[static_cast<std::size_t>(status)];
    }
    [[nodiscard]] std::ptrdiff_t reports(FrameStatus status) const {
        return std::ranges::count(statuses, status);
    }
};

LinkRun link_run(const std::string &fault, std::uint64_t seed = 1, int packets = 20) {
    EmulatedBoardOptions with = with_fault(fault);
    with.seed = seed;
    Host host(with);
    host.board.attach(true);
    LinkRun run;
    const auto receive_all = [&] {
        usb::Frame frame;
        while (const std::size_t size = host.board.take(frame)) {
            run.statuses.push_back(usb::decode(frame.data(), size, host.report));
            if (run.statuses.back() == FrameStatus::ok) {
                run.numbers.push_back(host.report.number);
            }
        }
    };
    receive_all();
    for (int i = 0; i < packets; ++i) {
        Command command;
        command.begins_numbering = i < 2;
        host.send(command);
        receive_all();
    }
    run.counters = ask<Counters>(host.board, Kind::counters);
    if (!with.faults.empty()) {
        const device::Fault &set = with.faults.front();
        run.strikes = host.board.line(set.direction).faults()[static_cast<std::size_t>(set.kind)];
    }
    return run;
}

bool are_consecutive(const std::vector<std::uint32_t> &numbers) {
    for (std::size_t i = 1; i < numbers.size(); ++i) {
        if (numbers[i] != numbers[i - 1] + 1) {
            return false;
        }
    }
    return true;
}

TEST(LinkFaults, AreNotThereUnlessSet) {
    const LinkRun run = link_run("");
    EXPECT_EQ(run.commands(FrameStatus::ok), 20U);
    EXPECT_EQ(run.reports(FrameStatus::ok), 21);
    EXPECT_EQ(run.statuses.size(), 21U);
    EXPECT_TRUE(are_consecutive(run.numbers));
}

TEST(LinkFaults, DropPackets) {
    EXPECT_EQ(link_run("drop:out:#10").commands(FrameStatus::ok), 19U);
    const LinkRun in = link_run("drop:in:#10");
    EXPECT_EQ(in.reports(FrameStatus::ok), 20);
    EXPECT_EQ(in.numbers.back() - in.numbers.front(), 20U); // one is missing
    EXPECT_EQ(in.commands(FrameStatus::ok), 20U);
    EXPECT_EQ(link_run("stall:out").commands(FrameStatus::ok), 0U);
    EXPECT_EQ(link_run("stall:in").statuses.size(), 0U);
}

TEST(LinkFaults, DelayPackets) {
    // By a period and a half, number 10 arrives after number 11.
    const LinkRun out = link_run("delay:out:#10:1.5");
    EXPECT_EQ(out.commands(FrameStatus::ok), 19U);
    EXPECT_EQ(out.commands(FrameStatus::stale), 1U);
    const LinkRun in = link_run("delay:in:#10:2");
    ASSERT_EQ(in.numbers.size(), 21U);
    EXPECT_FALSE(are_consecutive(in.numbers));
    // 11 without 10; 12 together with 10.
    EXPECT_EQ(in.numbers[9], in.numbers[8] + 2);
    EXPECT_EQ(in.numbers[10], in.numbers[8] + 1);
}

TEST(LinkFaults, SwapPackets) {
    const LinkRun out = link_run("reorder:out:#10");
    EXPECT_EQ(out.commands(FrameStatus::ok), 19U);
    EXPECT_EQ(out.commands(FrameStatus::stale), 1U);
    const LinkRun in = link_run("reorder:in:#10");
    ASSERT_EQ(in.numbers.size(), 21U);
    EXPECT_EQ(in.numbers[9], in.numbers[8] + 2);
    EXPECT_EQ(in.numbers[10], in.numbers[8] + 1);
    EXPECT_EQ(in.numbers[11], in.numbers[8] + 3);
}

TEST(LinkFaults, DamagePackets) {
    const LinkRun corrupt = link_run("corrupt:out:#10");
    EXPECT_EQ(corrupt.commands(FrameStatus::ok), 19U);
    EXPECT_EQ(corrupt.commands(FrameStatus::wrong_crc), 1U);
    EXPECT_EQ(link_run("corrupt:in:1").reports(FrameStatus::wrong_crc), 21);
    EXPECT_EQ(link_run("truncate:out").commands(FrameStatus::wrong_size), 20U);
    EXPECT_EQ(link_run("truncate:in:#3").reports(FrameStatus::wrong_size), 1);
}

TEST(LinkFaults, RepeatPackets) {
    const LinkRun out = link_run("repeat:out:#10");
    EXPECT_EQ(out.commands(FrameStatus::ok), 20U);
    EXPECT_EQ(out.commands(FrameStatus::repeated), 1U);
    const LinkRun in = link_run("repeat:in:#10");
    ASSERT_EQ(in.numbers.size(), 22U);
    EXPECT_EQ(in.numbers[9], in.numbers[10]);
}

TEST(LinkFaults, StrikeAtRandomByTheirSeed) {
    const LinkRun run = link_run("drop:in:0.3", 7, 400);
    // Binomial: 120 of 401, with a standard deviation of 9.
    EXPECT_NEAR(static_cast<double>(run.strikes), 120.3, 45.0);
    EXPECT_EQ(run.numbers, link_run("drop:in:0.3", 7, 400).numbers);
    EXPECT_NE(run.numbers, link_run("drop:in:0.3", 8, 400).numbers);
}

// Faults of the device.

/// State and report after a fault acted on a driving board.
struct DeviceRun {
    BoardState state = BoardState::starting;
    std::uint16_t faults = 0;
    Report report;
};

DeviceRun device_run(const std::string &fault) {
    Host host;
    host.begin();
    host.exchange(driving({0.2, -0.15, 0.2}), 20);
    if (!fault.empty()) {
        host.board.set_fault(device::parse_fault(fault));
    }
    host.exchange(driving({0.2, -0.15, 0.2}), 20);
    host.receive();
    return {host.state(), host.faults(), host.report};
}

TEST(DeviceFaults, AreNoticedByTheBoard) {
    const DeviceRun sound = device_run("");
    EXPECT_EQ(sound.state, BoardState::driving);
    EXPECT_EQ(sound.faults, 0);
    struct Case {
        std::string fault;
        std::uint16_t faults = 0;
        BoardState state = BoardState::fault_braking;
    };
    for (const Case &requested :
         {Case{"stop", Faults::kStop}, Case{"disable", Faults::kStop},
          Case{"brown-out:12", Faults::kSupply}, Case{"brown-out:20", Faults::kSupply},
          Case{"hot-stage:95", Faults::kTemperature},
          Case{"failed-stage", Faults::kAmplifier, BoardState::fault_open},
          Case{"failed-sensor:2", Faults::kSensor, BoardState::fault_open}}) {
        const DeviceRun run = device_run(requested.fault);
        EXPECT_EQ(run.faults, requested.faults) << requested.fault;
        EXPECT_EQ(run.state, requested.state) << requested.fault;
        EXPECT_EQ(run.report.faults, requested.faults) << requested.fault;
    }
    EXPECT_TRUE(device_run("stop").report.is_stopped);
    EXPECT_FALSE(device_run("disable").report.is_enabled);
    EXPECT_TRUE(usb::is_nan(device_run("failed-sensor:2").report.current_A[1]));
    EXPECT_FALSE(usb::is_nan(device_run("failed-sensor:2").report.current_A[0]));
}

/// Counts and currents of a device whose hand and drives move it.
struct Moved {
    std::array<std::int32_t, 3> counts{};
    std::array<double, 3> current_A{}; ///< reported
    Vector3 true_A{Vector3::Zero()};
    double largest_A = 0.0; ///< true, of channel 2, from 5 ms on
};

/// @param command  to drive, or to brake; a board that drives may find the fault, and brake
Moved moved_with(const std::string &fault,
                 const usb::Command &command = driving({0.1, 0.25, -0.2})) {
    Host host(with_fault(fault));
    host.begin();
    host.board.phantom().set_hand_target(testing::kOffCentre_m + Vector3(0.01, 0.02, 0.01));
    Moved moved;
    for (int i = 0; i < 150; ++i) {
        host.exchange(command);
        if (i > 5) {
            moved.largest_A =
                std::max(moved.largest_A, std::abs(host.board.phantom().truth().current_A[1]));
        }
    }
    EXPECT_TRUE(host.faults() == 0 || (!fault.empty() && host.faults() == Faults::kGenerating))
        << fault;
    moved.counts = host.report.counts;
    for (std::size_t i = 0; i < 3; ++i) {
        moved.current_A[i] = static_cast<double>(host.report.current_A[i]);
    }
    moved.true_A = host.board.phantom().truth().current_A;
    return moved;
}

// By the hand alone: a board that drives would find some of them.
TEST(DeviceFaults, OfEncodersChangeCounts) {
    const usb::Command brake;
    const Moved sound = moved_with("", brake);
    for (const std::int32_t counts : sound.counts) {
        EXPECT_GT(std::abs(counts), 50);
    }
    EXPECT_EQ(moved_with("stuck-encoder:2", brake).counts,
              (std::array<std::int32_t, 3>{sound.counts[0], 0, sound.counts[2]}));
    EXPECT_EQ(moved_with("reversed-encoder:1", brake).counts,
              (std::array<std::int32_t, 3>{-sound.counts[0], sound.counts[1], sound.counts[2]}));
    EXPECT_EQ(moved_with("crossed-encoders:1:3", brake).counts,
              (std::array<std::int32_t, 3>{sound.counts[2], sound.counts[1], sound.counts[0]}));
}

TEST(DeviceFaults, OfSensorsChangeCurrents) {
    const Moved sound = moved_with("");
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_GT(std::abs(sound.current_A[i]), 0.05);
        EXPECT_NEAR(sound.current_A[i], sound.true_A[static_cast<Eigen::Index>(i)], 1e-3);
    }
    const Moved reversed = moved_with("reversed-sensor:2");
    EXPECT_NEAR(reversed.current_A[1], -reversed.true_A[1], 1e-3);
    EXPECT_NEAR(reversed.current_A[0], reversed.true_A[0], 1e-3);
    const Moved crossed = moved_with("crossed-sensors:2:3");
    EXPECT_NEAR(crossed.current_A[1], crossed.true_A[2], 1e-3);
    EXPECT_NEAR(crossed.current_A[2], crossed.true_A[1], 1e-3);
}

TEST(DeviceFaults, OfMotorsChangeTorques) {
    EXPECT_GT(moved_with("").largest_A, 0.3);
    // Some milliamperes of 0.4 A remain, by the change of speed in a loop.
    EXPECT_LT(moved_with("open-winding:2").largest_A, 5e-3);
    const Moved crossed = moved_with("crossed-motors:2:3");
    EXPECT_NEAR(crossed.current_A[1], crossed.true_A[2], 1e-3);
    EXPECT_GT(crossed.true_A[2], 0.1); // driven by 0.25 V, not by −0.2 V
    EXPECT_LT(crossed.true_A[1], -0.1);
}

/// The board's own test of a device.
usb::SelfTestResult self_test(const std::string &fault) {
    Host host(with_fault(fault));
    host.begin();
    host.exchange({}, 200); // until it hangs still
    EXPECT_TRUE(order(host.board, Kind::self_test, usb::SelfTestOrder{0.8F, 20'000}));
    host.exchange({}, 700);
    const auto result = ask<usb::SelfTestResult>(host.board, Kind::self_test);
    EXPECT_EQ(result.state, usb::SelfTestState::completed) << fault;
    return result;
}

TEST(DeviceFaults, AreFoundByTheSelfTest) {
    const usb::SelfTestResult sound = self_test("");
    for (const usb::ChannelTest &channel : sound.channel) {
        EXPECT_EQ(channel.findings, 0);
        EXPECT_NEAR(channel.resistance_Ohm, 2.18, 0.05 * 2.18);
    }
    struct Case {
        std::string fault;
        std::uint16_t finding = 0; ///< of channel 2
    };
    for (const Case &requested : {Case{"open-winding:2", ChannelFindings::kOpenWinding},
                                  Case{"reversed-sensor:2", ChannelFindings::kReversedSensor},
                                  Case{"crossed-sensors:2:3", ChannelFindings::kCrossedSensor},
                                  Case{"stuck-encoder:2", ChannelFindings::kNoMotion},
                                  Case{"reversed-encoder:2", ChannelFindings::kReversedEncoder},
                                  Case{"crossed-encoders:2:3", ChannelFindings::kCrossedEncoder}}) {
        EXPECT_NE(self_test(requested.fault).channel[1].findings & requested.finding, 0)
            << requested.fault;
    }
}

TEST(DeviceFaults, RestartTheBoard) {
    for (const char *fault : {"restart@0.1-0.11", "brown-out:3@0.1-0.11"}) {
        Host host(with_fault(fault));
        host.begin();
        host.board.phantom().set_hand_target(testing::kOffCentre_m + Vector3(0.01, 0.02, 0.01));
        host.exchange(driving({0.2, 0.2, 0.2}), 50);
        EXPECT_EQ(host.state(), BoardState::driving);
        EXPECT_GT(std::abs(host.report.counts[0]), 10);
        EXPECT_FALSE(host.board.unplug_requested());
        const std::uint32_t before_us = host.report.measured_at_us;
        bool was_off = false;
        for (int i = 0; i < 40; ++i) {
            host.exchange(driving({0.2, 0.2, 0.2}));
            was_off = was_off || host.board.unplug_requested();
        }
        EXPECT_EQ(was_off, std::string(fault).starts_with("brown-out"));
        EXPECT_EQ(host.board.restarts(), 1U);
        EXPECT_LT(host.report.measured_at_us, before_us);
        EXPECT_EQ(host.report.number, host.report.measured_at_us / 1000 + 1);
        EXPECT_FALSE(host.report.has_command);
        EXPECT_EQ(host.report.last_rejection, FrameStatus::stale);
        EXPECT_EQ(host.state(), BoardState::starting);
        host.exchange(driving({0.2, 0.2, 0.2}), 30);
        EXPECT_EQ(host.state(), BoardState::braking);
        Command first;
        first.begins_numbering = true;
        host.exchange(first);
        host.exchange(driving({0.2, 0.2, 0.2}), 3);
        EXPECT_EQ(host.state(), BoardState::driving);
    }
}

TEST(DeviceFaults, EndAtTheirTimeOrOnCall) {
    Host host(with_fault("stop@0.06-0.08"));
    host.begin();
    while (host.board.time_s() < 0.058) {
        host.exchange(driving({0.1, 0.1, 0.1}));
    }
    EXPECT_EQ(host.state(), BoardState::driving);
    host.exchange(driving({0.1, 0.1, 0.1}), 5);
    EXPECT_EQ(host.faults(), Faults::kStop);
    EXPECT_TRUE(host.report.is_stopped);
    host.exchange(driving({0.1, 0.1, 0.1}), 20);
    EXPECT_FALSE(host.report.is_stopped);
    Command reset;
    reset.resets_faults = true;
    host.exchange(reset, 3);
    EXPECT_EQ(host.state(), BoardState::braking);
    host.board.set_fault(device::parse_fault("stop"));
    host.exchange(reset, 3);
    EXPECT_EQ(host.faults(), Faults::kStop);
    host.board.clear_faults();
    host.exchange(reset, 3);
    EXPECT_EQ(host.faults(), 0);
}

TEST(DeviceFaults, AskForAnUnplug) {
    Host host(with_fault("unplug@0.05-0.07"));
    host.begin();
    host.exchange(driving({0.1, 0.1, 0.1}), 5);
    EXPECT_FALSE(host.board.unplug_requested());
    host.exchange(driving({0.1, 0.1, 0.1}), 20);
    EXPECT_TRUE(host.board.unplug_requested());
    host.board.detach();
    host.pass_ms(30);
    EXPECT_FALSE(host.board.unplug_requested());
}

} // namespace
} // namespace springdrive::emulator
