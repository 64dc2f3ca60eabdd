// Covers app/exhibit/day_log.cpp.
#include "app/exhibit/day_log.h"
#include "tests/engine/session/session_fixture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <string>

namespace springdrive::app::exhibit {
namespace {

std::chrono::system_clock::time_point at_local(const char *time) {
    std::tm parts{};
    EXPECT_NE(strptime(time, "%Y-%m-%d %H:%M:%S", &parts), nullptr);
    parts.tm_isdst = -1;
    return std::chrono::system_clock::from_time_t(std::mktime(&parts));
}

TEST(ExhibitDayLog, AppendsOneLineAnEventWithTheLocalTime) {
    const std::filesystem::path file = testing::fresh_folder("day_log") / "new folder" / "day.log";
    {
        DayLog log(file);
        log.note("visitor 1 begins", at_local("2026-11-25 10:03:21"));
    }
    DayLog again(file); // of a second run on the same day
    again.note("two\nlines", at_local("2026-11-25 10:05:00"));
    EXPECT_EQ(testing::contents_of(file), "2026-11-25 10:03:21  visitor 1 begins\n"
                                          "2026-11-25 10:05:00  two lines\n");
    EXPECT_EQ(again.take_error(), "");
    DayLog silent{std::filesystem::path()};
    silent.note("one");
    EXPECT_EQ(silent.take_error(), "");
}

TEST(ExhibitDayLog, AFullDiskIsSaidOnceAndWhatIsMissingLater) {
    const std::filesystem::path folder = testing::fresh_folder("day_log_full");
    const std::filesystem::path file = folder / "day.log";
    std::filesystem::create_symlink("/dev/full", file); // each write fails, as on a full disk
    DayLog log(file);
    log.note("one");
    EXPECT_NE(log.take_error().find("disk full"), std::string::npos);
    log.note("two");
    log.note("three");
    EXPECT_EQ(log.take_error(), "");
    std::filesystem::remove(file); // there is room again
    log.note("four", at_local("2026-11-25 10:00:00"));
    log.note("five", at_local("2026-11-25 10:00:01"));
    EXPECT_EQ(testing::contents_of(file),
              "2026-11-25 10:00:00  3 lines before this one could not be written\n"
              "2026-11-25 10:00:00  four\n"
              "2026-11-25 10:00:01  five\n");
}

/// Against the telemetry itself, row by row, however many ticks a frame has.
TEST(ExhibitDayWatch, FindsStopsAndThePeaksOfWhatIsDriven) {
    session::SessionOptions options = testing::scripted("plate");
    session::Session session(options);
    session.start();
    DayWatch watch;
    DayFigures figures;
    std::vector<std::string> events;
    const auto run = [&](double seconds) {
        for (double passed_s = 0.0; passed_s < seconds; passed_s += testing::kFrame_s) {
            session.advance(testing::kFrame_s);
            for (std::string &event : watch.update(session, figures)) {
                events.push_back(std::move(event));
            }
        }
    };
    run(4.0);
    ASSERT_TRUE(session.latest().contact.touching);
    EXPECT_TRUE(events.empty());
    session.servo().emergency_stop();
    run(1.0);
    session.leave_path();
    session.hand().move_to(session.hand().target_m() + Vector3(0.0, 0.05, 0.0));
    run(1.0);
    session.servo().let_go_on();
    run(3.0);
    ASSERT_EQ(events.size(), 2U);
    EXPECT_EQ(events[0], "stopped: emergency stop");
    EXPECT_TRUE(events[1].starts_with("running again after ")) << events[1];
    EXPECT_EQ(figures.trips, 1U);
    EXPECT_EQ(figures.recovered, 1U);
    EXPECT_EQ(figures.losses, 0U);
    EXPECT_NEAR(figures.longest_recovery_s, 3.2, 0.3); // 2 s, rest, and the gains' second
    const record::ChannelStore &store = session.servo().history().store();
    double peak_N = 0.0;
    double peak_V = 0.0;
    for (std::uint64_t row = store.begin(); row < store.end(); ++row) {
        const servo::ServoSample sample = session::sample_at(store, row);
        if (servo::lets_pass(sample.safety.state)) {
            peak_N = std::max(peak_N, sample.tip_force_N.norm());
            peak_V = std::max(peak_V, sample.command.e_W_V.cwiseAbs().maxCoeff());
        }
    }
    EXPECT_GT(peak_N, 0.5);
    EXPECT_DOUBLE_EQ(figures.peak_force_N, peak_N);
    EXPECT_DOUBLE_EQ(figures.peak_voltage_V, peak_V);

    // A stop before the motors ran again: both are recovered at once.
    events.clear();
    session.servo().emergency_stop();
    run(1.0);
    session.servo().let_go_on();
    run(0.2);
    session.servo().emergency_stop();
    run(1.0);
    session.servo().let_go_on();
    run(3.0);
    ASSERT_EQ(events.size(), 3U);
    EXPECT_EQ(events[0], "stopped: emergency stop");
    EXPECT_EQ(events[1], "stopped: emergency stop");
    EXPECT_TRUE(events[2].starts_with("running again after ")) << events[2];
    EXPECT_EQ(figures.trips, 3U);
    EXPECT_EQ(figures.trips_while_recovery, 1U);
    EXPECT_EQ(figures.recovered, 2U);
    session.stop();
}

TEST(ExhibitDayLog, SumsUp) {
    DayFigures figures;
    figures.visitors = 40;
    figures.scenes = 112;
    figures.peak_force_N = 3.456;
    EXPECT_EQ(summary_of(figures),
              "40 visitors, 112 scenes; 0 stops, 0 healed; the device was lost 0 times; "
              "peak force 3.46 N, peak voltage 0.00 V; longest frame 0 ms");
    figures.trips = 4;
    figures.trips_while_recovery = 1;
    figures.recovered = 3;
    figures.longest_recovery_s = 11.2;
    EXPECT_TRUE(
        summary_of(figures).starts_with("40 visitors, 112 scenes; 4 stops (1 while healing), "
                                        "3 healed, the longest after 11 s; "))
        << summary_of(figures);
}

} // namespace
} // namespace springdrive::app::exhibit
