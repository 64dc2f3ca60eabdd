// What the experimenter sees and does during a sitting. The stimuli are hidden at first, so that
// nothing in the experimenter's face or voice can tell of them.
#pragma once

#include "app/study/experimenter/live_fit.h"
#include "app/study/sitting/sitting_frame.h"
#include "app/study/sitting/sitting_state.h"
#include "app/widgets/rectangle.h"
#include "engine/session/session.h"
#include "engine/study/protocol/protocol.h"

#include <optional>
#include <string>
#include <vector>

namespace springdrive::app::study_screen {

enum class EndAsked : std::uint8_t { nothing, stop, leave };

struct ExperimenterPanelState {
    bool is_paused = false;
    bool shows_stimuli = false; ///< condition, level, answers and fit
    std::string error;          ///< why the device could not be zeroed
    std::string note;           ///< being typed
    double typed_s = 0.0;       ///< when its last key was, by ImGui::GetTime
    std::vector<std::string> notes_of_today;
    EndAsked asked = EndAsked::nothing; ///< until it is confirmed
};

struct ExperimenterActs {
    ExperimenterOrders orders;
    bool emergency_stop = false;
    bool zeroes_device = false;      ///< it is held in its zero pose
    std::optional<std::string> note; ///< to be stored
};

/// The column of buttons, the course of the session and the notes.
[[nodiscard]] ExperimenterActs draw_experimenter_panel(ExperimenterPanelState &panel,
                                                       const Rectangle &place,
                                                       const SittingState &state,
                                                       const session::Session &session,
                                                       const study::Protocol &protocol);

/// What is presented and answered, or that it is hidden. @param result  null: nothing yet
void draw_stimuli(ExperimenterPanelState &panel, const Rectangle &place, const SittingState &state,
                  const study::Protocol &protocol, const study::SeriesResult *result);

} // namespace springdrive::app::study_screen
