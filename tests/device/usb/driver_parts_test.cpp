// Covers device/usb/driver: report_stream, delay_meter and report_phase, by packets made here, and
// board_survey.
#include "device/usb/driver/report_stream.h"

#include "device/usb/driver/board_survey.h"
#include "device/usb/emulator/emulated_board.h"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <set>
#include <vector>

namespace springdrive::usb {
namespace {

using device::Arrival;

constexpr double kPeriod_s = 1e-3;

Report report_of(std::uint32_t number) {
    Report report;
    report.number = number;
    report.measured_at_us = 1000 * number;
    report.counts = {static_cast<std::int32_t>(number), 2, 3};
    report.state = BoardState::driving;
    report.has_command = true;
    return report;
}

Packet packet_of(const Report &report) {
    const Frame frame = encode(report);
    return {frame, frame.size(), 0.0};
}

TEST(ReportStream, NamesHowEachReportArrives) {
    ReportStream stream;
    EXPECT_EQ(stream.settle(0.0, kPeriod_s, true), Arrival::absent);
    EXPECT_TRUE(stream.take(packet_of(report_of(5))));
    EXPECT_EQ(stream.settle(0.005, kPeriod_s, true), Arrival::fresh);
    EXPECT_FALSE(stream.take(packet_of(report_of(5))));
    EXPECT_EQ(stream.settle(0.006, kPeriod_s, true), Arrival::repeated);
    Packet damaged = packet_of(report_of(6));
    damaged.data[20] ^= 1U;
    EXPECT_FALSE(stream.take(damaged));
    EXPECT_EQ(stream.settle(0.006, kPeriod_s, true), Arrival::corrupt);
    EXPECT_EQ(stream.counts().last_damage, FrameStatus::wrong_crc);
    EXPECT_TRUE(stream.take(packet_of(report_of(8))));
    EXPECT_FALSE(stream.take(packet_of(report_of(7))));
    EXPECT_EQ(stream.settle(0.008, kPeriod_s, true), Arrival::fresh);
    EXPECT_EQ(stream.counts().reports, 2U);
    EXPECT_EQ(stream.counts().lost, 2U); // 6 and 7: what comes too late is lost
    EXPECT_EQ(stream.counts().stale, 1U);
    EXPECT_EQ(stream.counts().repeated, 1U);
    EXPECT_EQ(stream.counts().corrupt, 1U);
    EXPECT_EQ(stream.counts().absent, 3U);
}

TEST(ReportStream, AReportOlderThanAPeriodIsLateByTheHostsClockOnly) {
    for (const bool is_timed : {true, false}) {
        ReportStream stream;
        for (std::uint32_t n = 1; n <= 100; ++n) {
            stream.take(packet_of(report_of(n)));
            // The host's clock began elsewhere, and reports need 0.2 ms.
            ASSERT_EQ(stream.settle(77.0 + 1e-3 * n + 0.2e-3, kPeriod_s, is_timed), Arrival::fresh);
        }
        stream.take(packet_of(report_of(101)));
        EXPECT_EQ(stream.settle(77.0 + 0.101 + 0.2e-3 + 0.99 * kPeriod_s, kPeriod_s, is_timed),
                  Arrival::fresh);
        stream.take(packet_of(report_of(102)));
        EXPECT_EQ(stream.settle(77.0 + 0.102 + 0.2e-3 + 1.01 * kPeriod_s, kPeriod_s, is_timed),
                  is_timed ? Arrival::late : Arrival::fresh);
        EXPECT_EQ(stream.counts().late, is_timed ? 1U : 0U);
    }
}

TEST(ReportStream, AClockThatDriftsMakesNothingLate) {
    ReportStream stream;
    for (std::uint32_t n = 1; n <= 100'000; ++n) {
        stream.take(packet_of(report_of(n)));
        ASSERT_NE(stream.settle(1e-3 * n * (1.0 + 1e-4), kPeriod_s, true), Arrival::late) << n;
    }
}

TEST(ReportStream, NumbersAndTimesGoOnBeyond32Bits) {
    ReportStream stream;
    Report report = report_of(0xffff'fffeU);
    report.measured_at_us = 0xffff'ff00U;
    stream.take(packet_of(report));
    const double before_s = stream.measured_s();
    report.number += 4;
    report.measured_at_us += 1000;
    stream.take(packet_of(report));
    EXPECT_EQ(stream.number(), 0x1'0000'0002U);
    EXPECT_NEAR(stream.measured_s() - before_s, 1e-3, 1e-9);
    EXPECT_EQ(stream.counts().lost, 3U);
}

TEST(ReportStream, ABoardThatForgotItsCommandsHasRestarted) {
    ReportStream stream;
    Report first = report_of(1);
    first.has_command = false;
    stream.take(packet_of(first));
    EXPECT_FALSE(stream.has_restarted()); // it has not had any yet
    stream.take(packet_of(report_of(900)));
    EXPECT_FALSE(stream.has_restarted());
    stream.take(packet_of(first));
    EXPECT_TRUE(stream.has_restarted());
    stream.take(packet_of(report_of(2)));
    EXPECT_TRUE(stream.has_restarted()); // until the next connection
    stream.begin();
    EXPECT_FALSE(stream.has_restarted());
}

/// Any order of packets: what the stream says against sets of numbers.
TEST(ReportStream, CountsRandomSequencesRight) {
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        std::mt19937_64 random(seed);
        ReportStream stream;
        std::set<std::uint32_t> taken;
        std::uint32_t sent = 1000;
        std::uint64_t corrupt = 0;
        std::uint64_t repeated = 0;
        std::uint64_t stale = 0;
        for (int i = 0; i < 300; ++i) {
            const auto what = std::uniform_int_distribution(0, 9)(random);
            sent += what == 0 ? std::uniform_int_distribution(2U, 9U)(random) : 1U;
            std::uint32_t number = sent;
            if (what == 1 && !taken.empty()) {
                number = *taken.rbegin() - std::uniform_int_distribution(0U, 3U)(random);
            }
            Packet packet = packet_of(report_of(number));
            if (what == 2) {
                packet.data[std::uniform_int_distribution<std::size_t>(0, 63)(random)] ^= 0x10U;
                ++corrupt;
            } else if (what == 3) {
                packet.size = std::uniform_int_distribution<std::size_t>(0, 63)(random);
                ++corrupt;
            } else if (!taken.empty() && number <= *taken.rbegin()) {
                ++(number == *taken.rbegin() ? repeated : stale);
            } else {
                taken.insert(number);
            }
            stream.take(packet);
            ASSERT_EQ(stream.has_report(), !taken.empty());
            if (!taken.empty()) {
                ASSERT_EQ(stream.newest().number, *taken.rbegin());
            }
        }
        const StreamCounts &counts = stream.counts();
        EXPECT_EQ(counts.reports, taken.size());
        EXPECT_EQ(counts.lost, *taken.rbegin() - *taken.begin() + 1 - taken.size());
        EXPECT_EQ(counts.corrupt, corrupt);
        EXPECT_EQ(counts.repeated, repeated);
        EXPECT_EQ(counts.stale, stale);
    }
}

TEST(DelayMeter, IsTheDefinitionOnTheBoardsClock) {
    DelayMeter meter;
    Report report = report_of(1);
    report.measured_at_us = 0xffff'ff00U; // the board's clock begins again meanwhile
    meter.sent(7, report.measured_at_us, true, 10.0);
    report.command_number = 7;
    report.command_arrived_at_us = report.measured_at_us + 400;
    report.applied_after_us = kNotApplied;
    report.measured_at_us += 1000;
    // On the host, 1.2 ms passed; on the board the command waited 0.6 ms for the report.
    EXPECT_NEAR(meter.take(report, 10.0012).value(), 0.6e-3, 1e-12);
    EXPECT_EQ(meter.delay().mean_s(), 0.0); // not applied yet
    report.applied_after_us = 37;
    EXPECT_FALSE(meter.take(report, 10.0022).has_value()); // once only
    EXPECT_NEAR(meter.delay().mean_s(), 437e-6, 1e-12);
    report.command_number = 8; // never sent by this host
    EXPECT_FALSE(meter.take(report, 10.0).has_value());
}

TEST(DelayMeter, KeepsMeanAndLargestOfTheLatest) {
    RecentTimes times;
    times.take(9.0);
    for (int i = 0; i < 600; ++i) {
        times.take(i % 2 == 0 ? 1.0 : 2.0);
    }
    EXPECT_NEAR(times.mean_s(), 1.5, 1e-12);
    EXPECT_EQ(times.largest_s(), 2.0);
}

TEST(ReportPhase, FollowsTheRoundTripsThatNineteenOfTwentyDoNotExceed) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> round_trip_s(100e-6, 300e-6);
    ReportPhase phase;
    for (int i = 0; i < 20'000; ++i) {
        phase.take(round_trip_s(random));
    }
    // T − margin − computation − the 95th percentile, 290 µs, to within some steps of 2 to 40 µs.
    EXPECT_NEAR(phase.report_after_us(50e-6, kPeriod_s), 1000 - 60 - 50 - 290, 25);
    EXPECT_EQ(phase.report_after_us(2e-3, kPeriod_s), 0); // never before the command
}

TEST(BoardSurvey, NamesAPlaceAsSysfsDoes) {
    using Ports = std::vector<std::uint8_t>;
    EXPECT_EQ(sysfs_name_of(1, Ports{2}), "1-2");
    EXPECT_EQ(sysfs_name_of(3, Ports{1, 2, 14}), "3-1.2.14");
    EXPECT_EQ(sysfs_name_of(2, Ports{}), "usb2");
}

TEST(BoardSurvey, TakesFirmwareAndSerialFromTheBoardsAnswer) {
    Identity identity = emulator::emulated_identity("A7");
    identity.firmware = {1, 20, 300};
    SurveyedBoard board;
    take_identity(encode(identity), board);
    EXPECT_EQ(board.serial, "A7");
    EXPECT_EQ(board.firmware, "springdrive emulator 1.20.300");
    EXPECT_EQ(board.obstacle, BoardObstacle::none);
    EXPECT_EQ(board.problem, "");
}

TEST(BoardSurvey, AnotherVersionOfTheProtocolIsNamedOnBothSides) {
    Identity identity = emulator::emulated_identity("A7");
    for (const auto &[oldest, newest] : {std::pair{0, 0}, {2, 9}}) {
        identity.oldest_version = static_cast<std::uint8_t>(oldest);
        identity.newest_version = static_cast<std::uint8_t>(newest);
        SurveyedBoard board;
        take_identity(encode(identity), board);
        EXPECT_EQ(board.obstacle, BoardObstacle::wrong_version);
        EXPECT_NE(board.problem.find("this program has version 1"), std::string::npos);
        EXPECT_EQ(board.serial, "A7"); // still known
    }
    identity.oldest_version = 0;
    SurveyedBoard board;
    take_identity(encode(identity), board);
    EXPECT_EQ(board.obstacle, BoardObstacle::none);
}

TEST(BoardSurvey, WhatIsNoAnswerOfABoardSaysSo) {
    auto damaged = encode(emulator::emulated_identity("A7"));
    damaged[20] ^= 1U;
    SurveyedBoard board;
    take_identity(damaged, board);
    EXPECT_EQ(board.obstacle, BoardObstacle::no_interface);
    EXPECT_NE(board.problem.find("checksum"), std::string::npos) << board.problem;
    SurveyedBoard silent;
    take_identity({}, silent);
    EXPECT_NE(silent.problem.find("refuses"), std::string::npos) << silent.problem;
}

} // namespace
} // namespace springdrive::usb
