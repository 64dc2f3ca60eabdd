// A stimulus as it is stored: intended beside delivered.
#pragma once

#include "engine/study/protocol/condition.h"
#include "engine/study/stimuli/delivery_meter.h"
#include "engine/study/stimuli/stimulus_measures.h"
#include "engine/study/store/study_contents.h"

#include <vector>

namespace springdrive::study {

/// Every measure that was intended or delivered, and lateness_s, all with the intended value;
/// peak_force_N and aside_m without. How far which may be off is for marking.h.
[[nodiscard]] Presentation presentation_of(const StimulusMeasures &intended,
                                           const DeliveredStimulus &delivered);

/// The tuning in contact, servo rate and delay, by their names in protocol files.
[[nodiscard]] std::vector<Setting> settings_of(const Condition &condition);

} // namespace springdrive::study
