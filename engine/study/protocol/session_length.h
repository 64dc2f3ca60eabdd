// How many trials a participant has, and how long they take.
#pragma once

#include "engine/study/protocol/protocol.h"

#include <cstddef>
#include <vector>

namespace springdrive::study {

/// Without marked trials. Fewest and most differ where a method decides when it is done.
struct BlockLength {
    int min_trials = 0; ///< practice and catch trials included
    int max_trials = 0;
    double min_s = 0.0; ///< with the breaks within the block
    double max_s = 0.0;
};

struct SessionLength {
    std::vector<BlockLength> blocks; ///< in the protocol's order
    int min_trials = 0;
    int max_trials = 0;
    double warm_up_s = 0.0;       ///< before the first trial
    double min_questions_s = 0.0; ///< the protocol's own, before and after the trials
    double max_questions_s = 0.0;
    double min_s = 0.0; ///< with all of this and all breaks, without instructions
    double max_s = 0.0;
    double longest_without_break_s = 0.0; ///< when all trials take their longest
};

/// A trial that takes `expected_response_s`, and half of `approach_s` for each approach.
[[nodiscard]] double usual_trial_s(const Protocol &protocol);

/// The same with the whole of `approach_s` each.
[[nodiscard]] double long_trial_s(const Protocol &protocol);

/// That a question takes [s]: to leave it out, to choose an answer, to write one.
inline constexpr double kShortQuestion_s = 5.0;
inline constexpr double kLongChoice_s = 20.0;
inline constexpr double kLongText_s = 60.0;

/// To stop the servo, change its rate and start it again at the spot [s]: in the pause of a trial
/// whose standard has another servo rate, delay or scene than the comparison.
inline constexpr double kRestart_s = 2.0;

[[nodiscard]] bool restarts_within_trial(const Protocol &protocol);

/// Lower bound of a method's trials.
[[nodiscard]] int min_trials(const Method &method);

/// @param warm_up_s  of the windings, before the first trial: see warm_up_trial.h
[[nodiscard]] SessionLength session_length(const Protocol &protocol, double warm_up_s = 0.0);

} // namespace springdrive::study
