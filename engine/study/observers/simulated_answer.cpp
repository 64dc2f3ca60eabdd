#include "engine/study/observers/simulated_answer.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

namespace springdrive::study {

namespace {

/// What the participant draws in a trial.
enum class Drawn : std::uint64_t { bias, perception, guess, time };

RandomKey key_of_draw(const SimulatedParticipant &participant, const PlannedTrial &planned,
                      Drawn what) {
    return child(child(RandomKey{planned.seed}, participant.seed),
                 static_cast<std::uint64_t>(what));
}

/// In (0, 1): no end of a distribution is drawn.
double inner_uniform(RandomKey key) { return std::clamp(uniform(key), 0x1p-53, 1.0 - 0x1p-53); }

double proportion_of(const PsychometricFunction &function, double level) {
    return proportion_at(
        function, function.family.scale == Scale::logarithmic ? std::max(0.0, level) : level);
}

/// The level to which it is set: about the threshold, distributed as F.
double setting_of(const Protocol &protocol, const PsychometricFunction &function, double drawn) {
    const Scale scale = function.family.scale;
    const double level =
        level_from(scale, on_scale(scale, function.threshold) +
                              core_argument(function.family.shape, drawn) / function.slope);
    const auto *adjustment = std::get_if<Adjustment>(&protocol.method);
    return adjustment == nullptr
               ? level
               : std::clamp(level, adjustment->minimum_level, adjustment->maximum_level);
}

Response response_of(const Protocol &protocol, const SimulatedParticipant &participant,
                     const PlannedTrial &planned, double level) {
    const auto draw = [&](Drawn what) {
        return inner_uniform(key_of_draw(participant, planned, what));
    };
    if (protocol.task.kind == TaskKind::adjustment) {
        return Adjusted{setting_of(protocol, participant.function, draw(Drawn::perception))};
    }
    const bool is_biased = draw(Drawn::bias) < std::abs(participant.bias);
    const bool is_positive = draw(Drawn::perception) < proportion_of(participant.function, level);
    if (protocol.task.kind == TaskKind::yes_no) {
        return YesNo{is_biased ? participant.bias > 0.0 : is_positive};
    }
    const int alternatives = protocol.task.alternatives;
    if (is_biased) {
        return Chosen{participant.bias > 0.0 ? 1 : alternatives};
    }
    const int right = planned.target.value();
    if (is_positive) {
        return Chosen{right};
    }
    const auto further = static_cast<int>(below(key_of_draw(participant, planned, Drawn::guess),
                                                static_cast<std::size_t>(alternatives - 1)));
    return Chosen{(right + further) % alternatives + 1};
}

} // namespace

SimulatedAnswer simulated_answer(const Protocol &protocol, const SimulatedParticipant &participant,
                                 const PlannedTrial &planned, double level) {
    const double deviations = standard_normal(key_of_draw(participant, planned, Drawn::time));
    const double time_s =
        participant.response_median_s * std::exp(participant.response_spread * deviations);
    if (time_s > protocol.timing.response_s) {
        return {NoResponse{}, std::nullopt};
    }
    return {response_of(protocol, participant, planned, level), time_s};
}

} // namespace springdrive::study
