// What a check of a protocol adds where a person is to take part: a simulated observer has neither
// keys nor a screen.
#pragma once

#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/protocol_finding.h"

#include <string>

namespace springdrive::app::study_screen {

/// Errors: names in `responses.keys` that nobody can press, and an adjustment of what cannot be
/// changed while it is felt. Warnings: texts that are too long to be read on a screen of 1280 ×
/// 720.
/// @throw InputError if there is no font
[[nodiscard]] study::ProtocolFindings check_for_persons(const study::Protocol &protocol);

/// The first of its errors as "WHERE: WHAT; REMEDY"; empty if there is none.
[[nodiscard]] std::string what_keeps_persons_out(const study::Protocol &protocol);

} // namespace springdrive::app::study_screen
