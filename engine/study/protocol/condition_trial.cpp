#include "engine/study/protocol/condition_trial.h"

#include "base/parallel.h"

#include <fmt/core.h>

namespace springdrive::study {

std::vector<StimulusTrial> try_conditions(const Protocol &protocol, const StudySetting &setting,
                                          const std::vector<Presented> &presented) {
    std::vector<StimulusTrial> trials(presented.size());
    for_each_in_parallel(presented.size(), all_processors(), [&](std::size_t i) {
        trials[i] = try_stimulus(protocol, setting, presented[i]);
    });
    return trials;
}

ProtocolFindings findings_of(const Protocol &protocol, const std::vector<StimulusTrial> &trials) {
    ProtocolFindings findings;
    for (const StimulusTrial &trial : trials) {
        if (!trial.trip.empty()) {
            findings.push_back({Severity::error, trial.name,
                                "the safety monitor trips in simulation: " + trial.trip,
                                "make the stimulus weaker, or softer"});
            continue;
        }
        if (protocol.stimulus != StimulusForm::stroke && !trial.has_touched) {
            findings.push_back({Severity::error, trial.name,
                                "the simulated hand never touches the surface",
                                "move the spot, or turn its normal out of the surface"});
        }
        if (trial.has_touched && trial.failure != StimulusFailure::none) {
            findings.push_back({Severity::error, trial.name,
                                fmt::format("with a simulated hand {}", description(trial.failure)),
                                "make the stimulus weaker, or turn it less"});
        }
        if (trial.stimulus.hold != Hold::cup && trial.delivered.aside_m > kMaxSlide_m) {
            findings.push_back({Severity::error, trial.name,
                                fmt::format("a simulated hand slides {:.1f} mm off the spot; at "
                                            "most {:g} mm",
                                            1e3 * trial.delivered.aside_m, 1e3 * kMaxSlide_m),
                                "choose a flatter spot, press less, or set hold = \"cup\""});
        }
        if (trial.shaking_m_per_s > kMaxShaking_m_per_s) {
            findings.push_back({Severity::error, trial.name,
                                fmt::format("the tip shakes with {:.0f} mm/s while a simulated "
                                            "hand holds still; at most {:g} mm/s",
                                            1e3 * trial.shaking_m_per_s, 1e3 * kMaxShaking_m_per_s),
                                "lower K_P_V_per_rad or K_D_Vs_per_rad"});
        }
        if (trial.delivered.is_limited) {
            findings.push_back({Severity::warning, trial.name,
                                fmt::format("the servo holds its force back in simulation; the "
                                            "largest is {:.2f} N",
                                            trial.delivered.peak_force_N),
                                "make the stimulus weaker, or it is not what it says"});
        }
    }
    return findings;
}

} // namespace springdrive::study
