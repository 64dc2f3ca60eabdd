// What is said over the scene, where people look: one message at a time, the most important first,
// with the button that does it.
//
//   Session, OpenedRecord ──► SceneSituation ──► message_for ──► panels/scene_overlay
#pragma once

#include "engine/servo/safety_status.h"

#include <cstdint>
#include <optional>
#include <string>

namespace springdrive::app {

/// All that the message depends on.
struct SceneSituation {
    servo::SafetyStatus safety;
    bool is_lost = false;          ///< the device does not answer
    bool reconnects = false;       ///< a lost device is connected again by itself
    bool is_lent = false;          ///< a step of the assistant moves the device
    bool is_released = false;      ///< the device is kept braking, by the assistant
    bool is_zeroed = true;         ///< its angles are known
    bool is_paused = false;        ///< a simulated device stands still
    bool touching = false;         ///< a surface
    bool is_inside = false;        ///< the tip lies in a solid without touching it
    bool can_move_hand = true;     ///< it is simulated, and follows no path
    std::string record;            ///< the file that is shown instead of the present; else empty
    std::string scene_of_record{}; ///< if it is not the one that is shown; else empty
};

/// What a message's button does.
enum class SceneAction : std::uint8_t { none, reset, go_on, show_present, zero, lift_hand };

/// The colour of the plate.
enum class SceneUrgency : std::uint8_t {
    stopped, ///< until somebody acts
    waits,   ///< something is to be done before the device can be felt
    hint,    ///< all is well
};

struct SceneMessage {
    const char *name; ///< in reports
    SceneUrgency urgency = SceneUrgency::hint;
    std::string text;
    std::string more{};      ///< a second sentence, less prominent; may be empty
    const char *button = ""; ///< its label; empty: there is nothing to press
    SceneAction action = SceneAction::none;
};

/// Nothing while the device is ready and the present is shown.
[[nodiscard]] std::optional<SceneMessage> message_for(const SceneSituation &now);

} // namespace springdrive::app
