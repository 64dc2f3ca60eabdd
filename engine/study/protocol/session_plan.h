// What a protocol comes to: trials, minutes, and how its trials are analysed.
#pragma once

#include "engine/study/analysis/precision_plan.h"
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

/// @param warm_up_s  of the windings, before the first trial: see `predicted_warm_up_s`
[[nodiscard]] SessionLength session_length(const Protocol &protocol, double warm_up_s = 0.0);

// How the trials of a protocol are analysed; so also what its precision is reckoned with.

// @pre of all: validate(protocol) is empty

/// The function that is fitted: the method's own (QUEST+), or that of [expected]. Without both, a
/// cumulative normal on a linear scale, or Weibull's function on a logarithmic one; the scale is
/// the method's, and that of constant stimuli is logarithmic if they are a forced choice among
/// levels above 0.
[[nodiscard]] FunctionFamily analysis_family(const Protocol &protocol);

/// With which all fits are made: the method's own (QUEST+), else `usual_priors`.
[[nodiscard]] FunctionPriors analysis_priors(const Protocol &protocol);

/// Who [expected] describes. @pre the protocol has it
[[nodiscard]] PsychometricFunction expected_observer(const Protocol &protocol);

/// The trials that the method takes of an observer in one condition, in the median of some runs.
[[nodiscard]] int usual_trials(const Protocol &protocol, const PsychometricFunction &observer);

/// How well one participant's threshold in one condition will be known: observers who are all
/// alike, analysed as the study's data are. Its `trials` are still to be named.
[[nodiscard]] PrecisionQuestion precision_question(const Protocol &protocol,
                                                   const PsychometricFunction &observer);

} // namespace springdrive::study
