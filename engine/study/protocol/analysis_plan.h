// How the trials of a protocol are analysed; so also what its precision is reckoned with.
#pragma once

#include "engine/study/analysis/precision_plan.h"
#include "engine/study/protocol/protocol.h"

namespace springdrive::study {

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
