// Results of a study, for people.
#pragma once

#include "engine/study/results/study_results.h"

#include <ostream>

namespace springdrive::app {

/// A line for each participant and condition, then one for each condition.
void write_results(std::ostream &out, const study::Protocol &protocol,
                   const study::StudyResults &results);

} // namespace springdrive::app
