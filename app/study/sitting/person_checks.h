// What a check of a protocol adds where a person is to take part: a simulated observer has neither
// keys nor a screen.
#pragma once

#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/protocol_check.h"
#include "engine/study/protocol/study_setting.h"

#include <string>

namespace springdrive::app::study_screen {

/// Errors: names in `responses.keys` that nobody can press, gestures along the way off a spot, and
/// an adjustment of what cannot be changed while it is felt. Warnings: texts that are too long to
/// be read on a screen of 1280 × 720.
/// @throw InputError if there is no font
[[nodiscard]] study::ProtocolFindings check_for_persons(const study::Protocol &protocol,
                                                        const study::StudySetting &setting);

/// The first of its errors as "WHERE: WHAT; REMEDY"; empty if there is none.
[[nodiscard]] std::string validate_for_participants(const study::Protocol &protocol,
                                                    const study::StudySetting &setting);

} // namespace springdrive::app::study_screen
