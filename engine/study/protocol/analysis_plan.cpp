#include "engine/study/protocol/analysis_plan.h"

#include "base/assertions.h"
#include "engine/study/analysis/simulated_study.h"
#include "engine/study/protocol/session_length.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <variant>
#include <vector>

namespace springdrive::study {

namespace {

Scale scale_of(const Protocol &protocol) {
    if (const auto *staircases = std::get_if<Staircases>(&protocol.method)) {
        return staircases->scale;
    }
    if (const auto *adjustment = std::get_if<Adjustment>(&protocol.method)) {
        return adjustment->scale;
    }
    const bool are_ratios =
        is_forced_choice(protocol.task.kind) &&
        std::ranges::all_of(presentable_levels(protocol), [](double level) { return level > 0.0; });
    return are_ratios ? Scale::logarithmic : Scale::linear;
}

} // namespace

FunctionFamily analysis_family(const Protocol &protocol) {
    if (const auto *quest = std::get_if<QuestPlus>(&protocol.method)) {
        return quest->family;
    }
    if (protocol.expected) {
        return protocol.expected->family;
    }
    const Scale scale = scale_of(protocol);
    return {scale == Scale::linear ? Shape::cumulative_normal : Shape::weibull, scale};
}

FunctionPriors analysis_priors(const Protocol &protocol) {
    if (const auto *quest = std::get_if<QuestPlus>(&protocol.method)) {
        return priors_of(*quest);
    }
    return usual_priors(analysis_family(protocol), protocol.task, presentable_levels(protocol));
}

PsychometricFunction expected_observer(const Protocol &protocol) {
    SPRINGDRIVE_ASSERT(protocol.expected.has_value());
    const Expectation &expected = *protocol.expected;
    return {expected.family, expected.threshold, expected.slope, guess_range(protocol.task).minimum,
            expected.lapse};
}

int usual_trials(const Protocol &protocol, const PsychometricFunction &observer) {
    if (min_trials(protocol.method) == max_trials(protocol.method)) {
        return max_trials(protocol.method);
    }
    const RandomKey key = key_of(static_cast<std::uint64_t>(protocol.seed), 0);
    std::array<std::size_t, 21> trials{};
    for (std::size_t i = 0; i < trials.size(); ++i) {
        trials[i] = simulated_trials(protocol.method, observer, child(key, i)).size();
    }
    std::ranges::sort(trials);
    return static_cast<int>(trials[trials.size() / 2]);
}

PrecisionQuestion precision_question(const Protocol &protocol,
                                     const PsychometricFunction &observer) {
    PrecisionQuestion question;
    question.method = protocol.method;
    question.seed = static_cast<std::uint64_t>(protocol.seed);
    question.observers = {observer.family, known(observer.threshold), known(observer.slope),
                          known(observer.guess), known(observer.lapse)};
    question.analysis = analysis_priors(protocol);
    return question;
}

} // namespace springdrive::study
