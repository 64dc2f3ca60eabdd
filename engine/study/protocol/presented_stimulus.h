// From a condition of a protocol to what the servo is to present, and what is to come of it.
#pragma once

#include "engine/study/protocol/presented.h"
#include "engine/study/stimuli/stimulus.h"
#include "engine/study/stimuli/stimulus_measures.h"

namespace springdrive::study {

/// A force is steered where it is turned, and in a cup under the transpose map even if it is not:
/// there it would lean to wherever the hand leans. Pulses are not: they come on top of a force that
/// is along the normal.
[[nodiscard]] bool is_steered(const Protocol &protocol, const Condition &condition);

/// The longest that a hand stays in contact after a presentation, of all that the protocol
/// presents.
[[nodiscard]] double longest_glide_back_s(const Protocol &protocol);

/// After all of a protocol's stimuli the hand stays in contact equally long: the time is no hint.
[[nodiscard]] Stimulus stimulus_of(const Protocol &protocol, const StudySetting &setting,
                                   const Presented &presented);

/// By statics, see predicted_press.h. Of a direction nothing in a cup under the inverse map, where
/// it is the hand's; and of a blow nothing unless it is turned.
[[nodiscard]] StimulusMeasures intended_measures(const Protocol &protocol,
                                                 const StudySetting &setting,
                                                 const Presented &presented);

} // namespace springdrive::study
