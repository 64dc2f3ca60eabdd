// The trials of one participant in one condition.
#pragma once

#include "engine/study/methods/trial.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/store/study_contents.h"

#include <cstddef>
#include <string>
#include <vector>

namespace springdrive::study {

/// Trials of one run of the method: those of one block, without practice and catch trials.
struct MethodTrials {
    int block = 1; ///< as in `TrialPlace`
    std::vector<Trial> trials;
};

struct Series {
    std::string participant;
    int number = 1;            ///< of the participant
    std::size_t condition = 0; ///< index into `Protocol::conditions`
    /// A condition that is in more than one block has as many: each begins the method anew.
    std::vector<MethodTrials> runs;
    int catch_trials = 0; ///< that were not marked
    int catch_right = 0;  ///< in a forced choice, right; else answered with "yes"
};

/// By participant and, within one, in the protocol's order; those without trials are left out.
/// @param device  only trials of sessions on this kind
[[nodiscard]] std::vector<Series> series_of(const Protocol &protocol, const StudyContents &contents,
                                            DeviceKind device);

/// As the method saw it.
[[nodiscard]] PastMethodTrial method_trial(const Protocol &protocol, const Trial &trial);

/// Those that count for the analysis, of all runs.
[[nodiscard]] std::vector<PastMethodTrial> counting_trials(const Protocol &protocol,
                                                           const Series &series);

} // namespace springdrive::study
