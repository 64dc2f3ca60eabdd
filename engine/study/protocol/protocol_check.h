// A protocol checked as a whole, before anybody sits down: by reckoning, and by simulating each
// condition.
#pragma once

#include "engine/study/protocol/condition_trial.h"
#include "engine/study/protocol/protocol_finding.h"
#include "engine/study/protocol/session_length.h"
#include "engine/study/protocol/study_setting.h"

#include <vector>

namespace springdrive::study {

struct CheckOptions {
    bool simulates = true; ///< each condition at its extremes, some tenths of a second each
};

struct CheckedProtocol {
    ProtocolFindings findings; ///< errors first
    SessionLength length;
    std::vector<StimulusTrial> trials; ///< that were simulated
    double hottest_winding_C = 0.0;    ///< of the session, at the condition that heats most
};

/// All checks, whatever they find.
/// @pre validate(protocol) is empty
/// @throw InputError if the device cannot be read.
[[nodiscard]] CheckedProtocol check_protocol(const Protocol &protocol,
                                             const ProtocolFolders &folders,
                                             const CheckOptions &options = {});

} // namespace springdrive::study
