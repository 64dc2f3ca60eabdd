#include "engine/study/analysis/precision_plan.h"
#include "engine/study/analysis/simulated_study.h"
#include "engine/study/protocol/checks.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <variant>
#include <vector>

namespace springdrive::study {

namespace {

/// The trials that a method takes of an observer, in the median of some runs.
int usual_trials(const Method &method, const PsychometricFunction &observer, RandomKey key) {
    if (fewest_trials(method) == most_trials(method)) {
        return most_trials(method);
    }
    std::array<std::size_t, 21> trials{};
    for (std::size_t i = 0; i < trials.size(); ++i) {
        trials[i] = simulated_trials(method, observer, child(key, i)).size();
    }
    std::ranges::sort(trials);
    return static_cast<int>(trials[trials.size() / 2]);
}

/// Observers who are as expected, analysed as the study's data will be.
PrecisionQuestion question_of(const Protocol &protocol, const Expectation &expected) {
    constexpr int kStudies = 60; // a median width to within some 5 %
    PrecisionQuestion question;
    question.method = protocol.method;
    question.studies = kStudies;
    question.seed = static_cast<std::uint64_t>(protocol.seed);
    question.observers = {expected.family, known(expected.threshold), known(expected.slope),
                          known(guess_range(protocol.task).minimum), known(expected.lapse)};
    if (const auto *quest = std::get_if<QuestPlus>(&protocol.method)) {
        question.analysis = {quest->family, quest->threshold.prior, quest->slope.prior,
                             quest->guess.prior, quest->lapse.prior};
    } else {
        question.analysis =
            usual_priors(expected.family, protocol.task, presentable_levels(protocol));
    }
    question.trials = {usual_trials(protocol.method,
                                    {expected.family, expected.threshold, expected.slope,
                                     guess_range(protocol.task).minimum, expected.lapse},
                                    key_of(question.seed, 0))};
    return question;
}

} // namespace

ProtocolFindings check_precision(const Protocol &protocol) {
    if (!protocol.expected) {
        return {
            {Severity::note, "precision", "to be expected is not known without [expected]", ""}};
    }
    const PrecisionQuestion question = question_of(protocol, *protocol.expected);
    if (const std::string wrong = what_is_wrong_with(question, protocol.task); !wrong.empty()) {
        return {{Severity::warning, "precision", "cannot be reckoned: " + wrong,
                 "give [expected] a function that fits the method"}};
    }
    const Precision precision = precision_by_trials(question).front();
    const bool ratios = question.analysis.family.scale == Scale::logarithmic;
    const double width = ratios ? std::exp(precision.median_width) : precision.median_width;
    return {{Severity::note, "precision",
             fmt::format("a participant's threshold in a condition is known to within {} {:.3g} "
                         "(95 % interval, from end to end, in the median), with {} trials and "
                         "observers as expected",
                         ratios ? "a factor of" : "a width of", width, precision.trials),
             ""}};
}

} // namespace springdrive::study
