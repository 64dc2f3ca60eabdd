// What is found when each stimulus of a protocol is presented to a simulated hand, before anybody
// sits down. The hand is the relaxed grip of `device::HandParameters`.
#pragma once

#include "engine/study/protocol/presented.h"
#include "engine/study/protocol/protocol_finding.h"
#include "engine/study/protocol/stimulus_trial.h"

#include <string>
#include <vector>

namespace springdrive::study {

struct ConditionTrial {
    std::string name;             ///< see `name_of`
    double largest_force_N = 0.0; ///< of the device at the tip, as the servo reckons it
    double slid_m = 0.0;          ///< along the surface, from where the tip first touched
    double deepest_m = 0.0;       ///< below the spot, along its normal
    double shaking_m_per_s = 0.0; ///< of the tip at the end of a press, the hand being still
    double generated_J = 0.0;     ///< largest reading of the energy observer
    bool has_touched = false;
    bool is_held_back = false; ///< the servo reduced the force
    bool is_in_cup = false;
    StimulusFailure failure = StimulusFailure::none;
    std::string trip; ///< of the safety monitor, with its numbers; empty: none
};

/// Deterministic; some tenths of a second for a second of stimulus at 1 kHz.
[[nodiscard]] ConditionTrial try_condition(const Protocol &protocol, const StudySetting &setting,
                                           const Presented &presented);

/// All of them, on all processors.
[[nodiscard]] std::vector<ConditionTrial> try_conditions(const Protocol &protocol,
                                                         const StudySetting &setting,
                                                         const std::vector<Presented> &presented);

/// The tip may slide so far from where it touched [m]. In a cup it yields, but does not slide.
inline constexpr double kMostSlide_m = 0.003;

/// And shake so fast [m/s]: as an oscillation by an encoder count, 0.03 mm at the tip, at 100 Hz.
inline constexpr double kMostShaking_m_per_s = 0.02;

/// What is wrong with what was seen.
[[nodiscard]] ProtocolFindings findings_of(const Protocol &protocol,
                                           const std::vector<ConditionTrial> &trials);

} // namespace springdrive::study
