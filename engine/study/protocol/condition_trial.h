// What is found when each stimulus of a protocol is presented to a simulated hand, before anybody
// sits down. The hand is the relaxed grip of `device::HandParameters`.
#pragma once

#include "engine/study/protocol/presented.h"
#include "engine/study/protocol/protocol_finding.h"
#include "engine/study/protocol/stimulus_trial.h"

#include <vector>

namespace springdrive::study {

/// Each as `try_stimulus` does, on all processors.
[[nodiscard]] std::vector<StimulusTrial> try_conditions(const Protocol &protocol,
                                                        const StudySetting &setting,
                                                        const std::vector<Presented> &presented);

/// The tip may slide so far from where it touched [m]. In a cup it yields, but does not slide.
inline constexpr double kMaxSlide_m = 0.003;

/// And shake so fast [m/s]: as an oscillation by an encoder count, 0.03 mm at the tip, at 100 Hz.
inline constexpr double kMaxShaking_m_per_s = 0.02;

/// What is wrong with what was seen.
[[nodiscard]] ProtocolFindings findings_of(const Protocol &protocol,
                                           const std::vector<StimulusTrial> &trials);

} // namespace springdrive::study
