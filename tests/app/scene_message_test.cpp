// Covers app/panels/scene_message.cpp: which message is over the scene, and what its button does.
#include "app/panels/scene_message.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <functional>
#include <string>
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

std::string text_for(const SceneSituation &now) {
    const std::optional<SceneMessage> message = message_for(now);
    return message ? message->text : "";
}

SceneAction action_for(const SceneSituation &now) {
    const std::optional<SceneMessage> message = message_for(now);
    return message ? message->action : SceneAction::none;
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

/// Each makes its message necessary; the first is the most important.
const std::vector<std::pair<std::string, std::function<void(SceneSituation &)>>> &by_importance() {
    static const std::vector<std::pair<std::string, std::function<void(SceneSituation &)>>> all{
        {"stopped", [](SceneSituation &now) { now.safety.state = SafetyState::tripped; }},
        {"record shown", [](SceneSituation &now) { now.record = "touch.rec"; }},
        {"paused", [](SceneSituation &now) { now.is_paused = true; }},
        {"waiting", [](SceneSituation &now) { now.is_lent = true; }},
        {"waiting", [](SceneSituation &now) { now.is_released = true; }},
        {"waiting", [](SceneSituation &now) { now.is_zeroed = false; }},
        {"inside", [](SceneSituation &now) { now.is_inside = true; }},
        {"waiting", [](SceneSituation &) {}},
    };
    return all;
}

TEST(SceneMessages, AreOneAtATimeTheMostImportantFirst) {
    for (std::size_t first = 0; first < by_importance().size(); ++first) {
        SceneSituation now = in_state(SafetyState::waiting);
        for (std::size_t i = first; i < by_importance().size(); ++i) {
            by_importance()[i].second(now);
        }
        const std::optional<SceneMessage> message = message_for(now);
        ASSERT_TRUE(message.has_value()) << first;
        EXPECT_EQ(message->name, by_importance()[first].first) << first;
    }
}

TEST(SceneMessages, OfAStopSayWhyAndOfferTheResetUnlessItIsInVain) {
    SceneSituation now = in_state(SafetyState::tripped, TripCause::emergency_stop);
    EXPECT_EQ(text_for(now), "Stopped: emergency stop. The motors brake.");
    EXPECT_EQ(action_for(now), SceneAction::reset);
    now.safety.cause = TripCause::device_lost;
    now.is_lost = true;
    EXPECT_EQ(action_for(now), SceneAction::none);
    EXPECT_NE(message_for(now)->more.find("in the tab Plant"), std::string::npos);
    now.reconnects = true;
    EXPECT_NE(message_for(now)->more.find("by itself"), std::string::npos);
    now.is_lost = false; // it is there again
    EXPECT_EQ(action_for(now), SceneAction::reset);
    now.safety.cause = TripCause::assertion;
    EXPECT_EQ(action_for(now), SceneAction::none);
    EXPECT_EQ(std::string(message_for(now)->button), "");
}

TEST(SceneMessages, BeforeTheStartSayWhatIsMissing) {
    SceneSituation now = in_state(SafetyState::waiting);
    EXPECT_NE(text_for(now).find("held still"), std::string::npos);
    EXPECT_EQ(action_for(now), SceneAction::none);
    now.touching = true;
    EXPECT_EQ(text_for(now), "Lift the tip to start.");
    EXPECT_EQ(action_for(now), SceneAction::lift_hand);
    now.is_zeroed = false;
    EXPECT_EQ(action_for(now), SceneAction::zero);
    now.is_released = true;
    EXPECT_EQ(action_for(now), SceneAction::none);
    EXPECT_EQ(text_for(now), "The device only brakes.");
    now.is_lent = true; // its motors may act
    EXPECT_NE(text_for(now).find("its motors may act"), std::string::npos);
}

TEST(SceneMessages, OfATipInsideStandUntilItIsOut) {
    for (const SafetyState state : {SafetyState::waiting, SafetyState::running}) {
        SceneSituation now = in_state(state);
        now.is_inside = true;
        EXPECT_EQ(text_for(now), "The tip is inside: pull out.");
        EXPECT_EQ(action_for(now), SceneAction::lift_hand);
        now.touching = true; // it pushes into another surface, as is usual
        EXPECT_NE(text_for(now), "The tip is inside: pull out.");
    }
}

TEST(SceneMessages, OfferNoButtonForAHandThatIsNotOurs) {
    for (const bool inside : {false, true}) {
        SceneSituation now = in_state(SafetyState::waiting);
        now.is_inside = inside;
        now.touching = !inside;
        now.can_move_hand = false;
        ASSERT_TRUE(message_for(now).has_value());
        EXPECT_EQ(action_for(now), SceneAction::none);
        EXPECT_EQ(std::string(message_for(now)->button), "");
    }
}

TEST(SceneMessages, TellARecordFromThePresent) {
    SceneSituation now = in_state(SafetyState::running);
    now.record = "touch.rec";
    EXPECT_EQ(text_for(now), "Record: touch.rec. The servo goes on.");
    EXPECT_EQ(action_for(now), SceneAction::show_present);
    EXPECT_EQ(message_for(now)->more, "");
    now.scene_of_record = "'bone.glb'";
    EXPECT_NE(message_for(now)->more.find("'bone.glb'"), std::string::npos);
    now.record.clear();
    now.is_paused = true;
    EXPECT_EQ(action_for(now), SceneAction::go_on);
}

} // namespace
} // namespace springdrive::app
