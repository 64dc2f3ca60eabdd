// Where a sitting is, for the experimenter. The participant sees nothing of it.
#pragma once

#include "engine/study/conduct/conduct.h"
#include "engine/study/stimuli/stimulus_run.h"
#include "engine/study/store/study_contents.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app::study_screen {

enum class SittingStep : std::uint8_t {
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

/// "waits for the answer"
[[nodiscard]] std::string_view description(SittingStep step);

/// "the hand approaches"
[[nodiscard]] std::string_view description(study::StimulusPhase phase);

struct SittingState {
    std::string participant;
    study::SessionId session = 0;
    SittingStep step = SittingStep::instructions;
    study::StimulusPhase phase = study::StimulusPhase::waiting; ///< of the present interval
    std::optional<study::PlannedTrial> trial;                   ///< the present one
    std::size_t interval = 0;                                   ///< of it, from 0
    std::size_t intervals = 0;
    std::vector<study::Trial> trials; ///< of the participant, all that are stored
    std::vector<std::string> marks;   ///< of the present trial, so far
    double left_s = 0.0;              ///< of a break
    double progress = 0.0;            ///< of the participant's trials, 0 to 1
};

} // namespace springdrive::app::study_screen
