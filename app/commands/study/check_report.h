// What a check of a protocol found, for people.
#pragma once

#include "engine/study/protocol/protocol_check.h"

#include <ostream>

namespace springdrive::app {

/// Findings, errors first; the session's length; the largest of what was simulated.
void write_study_check(std::ostream &out, const study::Protocol &protocol,
                       const study::CheckedProtocol &checked);

} // namespace springdrive::app
