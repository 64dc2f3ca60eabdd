// Covers app/panels/{scene_overlay,session_keeper}.cpp: which message is over the scene, what its
// button does, and what is listed of what has happened.
#include "app/panels/scene_overlay.h"

#include "app/panels/session_keeper.h"
#include "tests/engine/session/session_fixture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app {
namespace {

using servo::SafetyState;
using servo::TripCause;

SceneSituation in_state(SafetyState state, TripCause cause = TripCause::none) {
    SceneSituation now;
    now.safety.state = state;
    now.safety.cause = cause;
    return now;
}

TEST(SceneMessages, AreNoneWhileTheDeviceIsReady) {
    for (const SafetyState state :
         {SafetyState::starting, SafetyState::running, SafetyState::releasing}) {
        for (const bool touching : {false, true}) {
            SceneSituation now = in_state(state);
            now.touching = touching;
            EXPECT_FALSE(message_for(now).has_value());
        }
    }
}

TEST(SceneMessages, AreOneAtATimeTheMostImportantFirst) {
    // Each makes its message necessary; the first is the most important.
    const std::vector<std::pair<std::string, std::function<void(SceneSituation &)>>> by_importance{
        {"stopped", [](SceneSituation &now) { now.safety.state = SafetyState::tripped; }},
        {"record shown", [](SceneSituation &now) { now.record = "touch.rec"; }},
        {"paused", [](SceneSituation &now) { now.is_paused = true; }},
        {"waiting", [](SceneSituation &now) { now.is_lent = true; }},
        {"waiting", [](SceneSituation &now) { now.is_released = true; }},
        {"waiting", [](SceneSituation &now) { now.is_zeroed = false; }},
        {"inside", [](SceneSituation &now) { now.is_inside = true; }},
        {"waiting", [](SceneSituation &) {}},
    };
    for (std::size_t first = 0; first < by_importance.size(); ++first) {
        SceneSituation now = in_state(SafetyState::waiting);
        for (std::size_t i = first; i < by_importance.size(); ++i) {
            by_importance[i].second(now);
        }
        const std::optional<SceneMessage> message = message_for(now);
        ASSERT_TRUE(message.has_value()) << first;
        EXPECT_EQ(message->name, by_importance[first].first) << first;
    }
}

TEST(SceneMessages, SayWhatIsTheCaseAndOfferWhatHelps) {
    struct Case {
        const char *what;
        SafetyState state;
        std::function<void(SceneSituation &)> change;
        const char *text; ///< part of it
        SceneAction action;
        const char *more = ""; ///< part of it
    };
    const auto stopped_by = [](TripCause cause, bool is_lost = false, bool reconnects = false) {
        return [=](SceneSituation &now) {
            now.safety.cause = cause;
            now.is_lost = is_lost;
            now.reconnects = reconnects;
        };
    };
    const std::vector<Case> cases{
        {"stop", SafetyState::tripped, stopped_by(TripCause::emergency_stop),
         "Stopped: emergency stop. The motors brake.", SceneAction::reset},
        {"lost", SafetyState::tripped, stopped_by(TripCause::device_lost, true), "Stopped",
         SceneAction::none, "in the tab Plant"},
        {"lost, and comes again", SafetyState::tripped,
         stopped_by(TripCause::device_lost, true, true), "Stopped", SceneAction::none, "by itself"},
        {"there again", SafetyState::tripped, stopped_by(TripCause::device_lost, false, true),
         "Stopped", SceneAction::reset},
        {"assertion", SafetyState::tripped, stopped_by(TripCause::assertion), "Stopped",
         SceneAction::none},
        {"free", SafetyState::waiting, [](SceneSituation &) {}, "held still", SceneAction::none},
        {"touching", SafetyState::waiting, [](SceneSituation &now) { now.touching = true; },
         "Lift the tip to start.", SceneAction::lift_hand},
        {"not zeroed", SafetyState::waiting, [](SceneSituation &now) { now.is_zeroed = false; }, "",
         SceneAction::zero},
        {"released", SafetyState::waiting, [](SceneSituation &now) { now.is_released = true; },
         "The device only brakes.", SceneAction::none},
        {"lent", SafetyState::waiting,
         [](SceneSituation &now) { now.is_released = now.is_lent = true; }, "its motors may act",
         SceneAction::none},
        {"inside", SafetyState::waiting, [](SceneSituation &now) { now.is_inside = true; },
         "The tip is inside: pull out.", SceneAction::lift_hand},
        {"inside, running", SafetyState::running, [](SceneSituation &now) { now.is_inside = true; },
         "The tip is inside: pull out.", SceneAction::lift_hand},
        {"hand of others", SafetyState::waiting,
         [](SceneSituation &now) {
             now.touching = true;
             now.can_move_hand = false;
         },
         "Lift", SceneAction::none},
        {"inside by others", SafetyState::waiting,
         [](SceneSituation &now) {
             now.is_inside = true;
             now.can_move_hand = false;
         },
         "inside", SceneAction::none},
        {"record", SafetyState::running, [](SceneSituation &now) { now.record = "touch.rec"; },
         "Record: touch.rec. The servo goes on.", SceneAction::show_present},
        {"record of a scene", SafetyState::running,
         [](SceneSituation &now) {
             now.record = "touch.rec";
             now.scene_of_record = "'bone.glb'";
         },
         "Record: touch.rec", SceneAction::show_present, "'bone.glb'"},
        {"paused", SafetyState::running, [](SceneSituation &now) { now.is_paused = true; }, "",
         SceneAction::go_on},
    };
    for (const Case &one : cases) {
        SceneSituation now = in_state(one.state);
        one.change(now);
        const std::optional<SceneMessage> message = message_for(now);
        ASSERT_TRUE(message.has_value()) << one.what;
        EXPECT_NE(message->text.find(one.text), std::string::npos) << one.what << message->text;
        EXPECT_NE(message->more.find(one.more), std::string::npos) << one.what << message->more;
        EXPECT_EQ(message->action, one.action) << one.what;
        EXPECT_EQ(std::string(message->button).empty(), one.action == SceneAction::none);
    }
    SceneSituation now = in_state(SafetyState::running); // it pushes into another surface, as usual
    now.is_inside = now.touching = true;
    EXPECT_TRUE(!message_for(now) || message_for(now)->name != std::string("inside"));
}

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
