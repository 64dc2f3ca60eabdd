// Stands in for engine/study/observers/simulated_sitting.h: answers by the level alone, nothing is
// presented.
#pragma once

#include "engine/study/analysis/simulated_study.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/protocol/study_setting.h"

namespace springdrive::study {

struct SimulatedParticipant {
    PsychometricFunction function;
    double response_median_s = 0.6;
    double response_spread = 0.25;
    double bias = 0.0;
    std::uint64_t seed = 0;
};

enum class FeltStimuli : std::uint8_t { each_simulated, measured_once };

class SimulatedSitting {
public:
    SimulatedSitting(const Protocol &protocol, const StudySetting & /*setting*/,
                     const SimulatedParticipant &participant, FeltStimuli /*felt*/)
        : protocol_(protocol), participant_(participant) {}

    std::optional<TrialResult> present(const PlannedTrial &planned) {
        const Outcome outcome = answer_of(participant_.function, planned.presented.level,
                                          child(planned.key, participant_.seed));
        TrialResult result;
        result.response_time_s = participant_.response_median_s;
        if (is_forced_choice(protocol_.task.kind)) {
            const int right = planned.presented.target;
            const int other = (right + 1) % protocol_.task.alternatives;
            result.response = Chosen{(outcome.positive ? right : other) + 1};
        } else if (protocol_.task.kind == TaskKind::yes_no) {
            result.response = YesNo{outcome.positive};
        } else {
            result.response = Adjusted{outcome.setting};
        }
        return result;
    }

private:
    Protocol protocol_;
    SimulatedParticipant participant_;
};

} // namespace springdrive::study
