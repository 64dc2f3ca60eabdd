#include "app/panels/scene_message.h"

#include <fmt/format.h>

namespace springdrive::app {

namespace {

SceneMessage stopped(const SceneSituation &now) {
    SceneMessage message{
        "stopped", SceneUrgency::stopped,
        fmt::format("Stopped: {}. The motors brake.", servo::description(now.safety))};
    if (now.is_lost) {
        message.more = now.reconnects ? "No device: plug it in, it is connected again by itself."
                                      : "No device: connect it again in the tab Plant.";
        return message; // a reset would trip at once
    }
    if (servo::is_final(now.safety.cause)) {
        message.more = "Start springdrive again: no reset clears this.";
        return message;
    }
    message.button = "Reset";
    message.action = SceneAction::reset;
    return message;
}

SceneMessage record_shown(const SceneSituation &now) {
    SceneMessage message{"record shown", SceneUrgency::hint,
                         fmt::format("Record: {}. The servo goes on.", now.record)};
    if (!now.scene_of_record.empty()) {
        message.more = fmt::format("Not its scene: it was recorded on {}.", now.scene_of_record);
    }
    message.button = "show the present  R";
    message.action = SceneAction::show_present;
    return message;
}

/// A button only where the hand is ours to move.
SceneMessage with_lift(SceneMessage message, const SceneSituation &now, const char *button) {
    if (now.can_move_hand) {
        message.button = button;
        message.action = SceneAction::lift_hand;
    }
    return message;
}

/// What has to happen before the motors start: otherwise a reset seems to do nothing.
SceneMessage waiting(const SceneSituation &now) {
    if (now.is_lent) {
        return {"waiting", SceneUrgency::waits,
                "A step of the assistant has the device: its motors may act."};
    }
    if (now.is_released) {
        return {"waiting", SceneUrgency::waits, "The device only brakes.",
                "The assistant holds it."};
    }
    if (!now.is_zeroed) {
        return {"waiting",
                SceneUrgency::waits,
                "The board does not know where the device is.",
                "Hold the upper arm level and the forearm hanging, then:",
                "zero here",
                SceneAction::zero};
    }
    if (now.touching) {
        return with_lift({"waiting", SceneUrgency::waits, "Lift the tip to start.",
                          "The motors brake until the tip is lifted off the surface and held "
                          "still."},
                         now, "lift the tip");
    }
    return {"waiting", SceneUrgency::waits, "The motors start as soon as the tip is held still."};
}

} // namespace

std::optional<SceneMessage> message_for(const SceneSituation &now) {
    const bool waits = now.safety.state == servo::SafetyState::waiting;
    if (now.safety.state == servo::SafetyState::tripped) {
        return stopped(now);
    }
    if (!now.record.empty()) { // so that it is not taken for the present
        return record_shown(now);
    }
    if (now.is_paused) { // nothing else can happen until it goes on
        return SceneMessage{"paused", SceneUrgency::hint, "Paused: the device stands still.",
                            {},       "go on  P",         SceneAction::go_on};
    }
    if (waits && (now.is_lent || now.is_released || !now.is_zeroed)) {
        return waiting(now);
    }
    if (now.is_inside && !now.touching) {
        return with_lift({"inside", SceneUrgency::waits, "The tip is inside: pull out.",
                          "A surface is felt only from its outside."},
                         now, "pull it out");
    }
    if (waits) {
        return waiting(now);
    }
    return std::nullopt;
}

} // namespace springdrive::app
