// What a trial presents, and how it is stored: intended beside delivered.
#pragma once

#include "engine/study/protocol/presented.h"
#include "engine/study/stimuli/delivery_meter.h"
#include "engine/study/stimuli/stimulus_measures.h"
#include "engine/study/store/study_contents.h"

#include <vector>

namespace springdrive::study {

/// Index into `Protocol::conditions`. @pre the trial is of a sequence of the protocol
[[nodiscard]] std::size_t condition_of(const Protocol &protocol, const PlannedTrial &planned);

/// One after the other. @pre validate(protocol) is empty; the trial is of its sequence
[[nodiscard]] std::vector<Presented> intervals_of(const Protocol &protocol,
                                                  const PlannedTrial &planned);

/// The comparison alone, at another level than the planned one: of an adjustment.
[[nodiscard]] Presented comparison_at(const Protocol &protocol, const PlannedTrial &planned,
                                      double level);

/// Every measure that was intended or delivered, and lateness_s, all with the intended value;
/// peak_force_N and aside_m without. How far which may be off is for marking.h.
[[nodiscard]] Presentation presentation_of(const StimulusMeasures &intended,
                                           const DeliveredStimulus &delivered);

/// The tuning in contact, servo rate and delay, by their names in protocol files.
[[nodiscard]] std::vector<Setting> settings_of(const Condition &condition);

} // namespace springdrive::study
