#include "app/panels/event_log.h"

#include "tests/engine/session/session_fixture.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace springdrive::app {
namespace {

std::size_t count(const EventLog &log, EventLog::Kind kind, const std::string &text) {
    return static_cast<std::size_t>(
        std::ranges::count_if(log.events(), [&](const EventLog::Event &event) {
            return event.kind == kind && event.what.find(text) != std::string::npos;
        }));
}

TEST(EventLog, HoldsEveryTripAlsoOneThatIsResetWithinAFrame) {
    session::Session session(testing::scripted());
    EventLog log;
    testing::run(session, 1.5);
    log.update(session);
    EXPECT_EQ(count(log, EventLog::Kind::note, "scene plate.gltf"), 1U);
    EXPECT_EQ(count(log, EventLog::Kind::note, "motors running"), 1U);
    EXPECT_EQ(count(log, EventLog::Kind::trip, "stopped"), 0U);
    for (int trip = 0; trip < 3; ++trip) {
        session.servo().emergency_stop();
        session.advance(0.004);
        session.advance(0.004);
        session.servo().let_go_on();
        session.advance(0.004);
    }
    log.update(session);
    EXPECT_EQ(count(log, EventLog::Kind::trip, "stopped: emergency stop"), 3U);
    EXPECT_EQ(count(log, EventLog::Kind::note, "reset"), 3U);
    log.update(session); // nothing twice
    EXPECT_EQ(count(log, EventLog::Kind::trip, "stopped"), 3U);
}

TEST(EventLog, HoldsChangesOfTuningRateAndRecord) {
    const std::filesystem::path folder = testing::fresh_folder("event_log");
    session::Session session(testing::scripted());
    EventLog log;
    testing::run(session, 0.1);
    log.update(session);
    control::Tuning other = session.tuning().now();
    other.K_P_V_per_rad = 7.0;
    session.tuning().change(other, session.latest().time_s);
    session.set_servo_rate(2000.0);
    session.start_recording(folder / "t.rec");
    log.update(session);
    session.recording().stop();
    log.update(session);
    EXPECT_EQ(count(log, EventLog::Kind::change, "K_P 6 → 7 V/rad"), 1U);
    EXPECT_EQ(count(log, EventLog::Kind::note, "servo at 2000 Hz"), 1U);
    EXPECT_EQ(count(log, EventLog::Kind::note, "recording to"), 1U);
    EXPECT_EQ(count(log, EventLog::Kind::note, "record ended"), 1U);
    EXPECT_TRUE(std::ranges::is_sorted(log.events(), {}, &EventLog::Event::time_s));
}

} // namespace
} // namespace springdrive::app
