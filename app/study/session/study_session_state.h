// Where a session is, for the experimenter (the participant sees nothing of it), and what both
// people did in a frame.
#pragma once

#include "app/study/participant/answers.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/stimuli/stimulus.h"
#include "engine/study/store/study_contents.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app::study_screen {

enum class StudySessionStep : std::uint8_t {
    questionnaire,
    noise_check,
    instructions,
    warming_up,
    practice_begins,
    practice_ends,
    block_begins,
    in_break,
    paused,
    setting_up, ///< scene, servo rate
    device_lost,
    device_stopped,
    interval, ///< see `phase`
    between_intervals,
    response,
    after_response,
    over,
};

/// What a participant does in them: "waits for the answer".
inline constexpr std::array<std::string_view, 17> kStepDescriptions{
    "answers the questionnaire",
    "listens to the noise",
    "reads the instructions",
    "waits until the windings are warm, or cool, enough",
    "is told that the practice begins",
    "is told that it counts from now on",
    "is told that a new part begins",
    "has a break",
    "waits: paused",
    "waits for the scene",
    "waits for the device, which is not connected or not zeroed",
    "waits for the device, which was stopped",
    "feels",
    "waits for the next interval",
    "is asked",
    "has answered",
    "is through",
};
static_assert(kStepDescriptions.size() == static_cast<std::size_t>(StudySessionStep::over) + 1);
[[nodiscard]] constexpr std::string_view description(StudySessionStep step) {
    return kStepDescriptions[static_cast<std::size_t>(step)];
}

/// "the hand approaches"
[[nodiscard]] constexpr std::string_view description(study::StimulusPhase phase) {
    switch (phase) {
    case study::StimulusPhase::waiting:
        return "the hand comes to rest above the spot";
    case study::StimulusPhase::approaching:
        return "the hand approaches";
    case study::StimulusPhase::presenting:
        return "the stimulus is presented";
    case study::StimulusPhase::gliding_back:
        return "the gains glide back";
    case study::StimulusPhase::leaving:
        return "the hand leaves";
    case study::StimulusPhase::failed:
        return "it was broken off";
    case study::StimulusPhase::done:
        break;
    }
    return "it is over";
}

struct StudySessionState {
    std::string participant;
    study::SessionId session = 0;
    StudySessionStep step = StudySessionStep::instructions;
    study::StimulusPhase phase = study::StimulusPhase::waiting; ///< of the present interval
    std::optional<study::PlannedTrial> trial;                   ///< the present one
    std::size_t interval = 0;                                   ///< of it, from 0
    std::size_t intervals = 0;
    std::vector<study::Trial> trials; ///< of the participant, all that are stored
    std::vector<std::string> marks;   ///< of the present trial, so far
    double left_s = 0.0;              ///< of a break
    double progress = 0.0;            ///< of the participant's trials, 0 to 1
};

/// What the experimenter wants.
struct ExperimenterOrders {
    bool is_paused = false; ///< between trials, for as long as it is set
    bool stops = false;     ///< ends the session now; it can be resumed
    bool participant_leaves = false;
    bool repeats = false;        ///< the present trial does not count, and comes again
    bool skips_to_break = false; ///< a break before the next trial
    bool resets_device = false;  ///< after a stop
};

struct StudySessionFrame {
    std::vector<ParticipantInput> inputs; ///< in order; times by `ServoRun::now_s`
    ExperimenterOrders orders;
};

} // namespace springdrive::app::study_screen
