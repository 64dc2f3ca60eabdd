#include "engine/study/analysis/precision_plan.h"

#include "base/parallel.h"
#include "engine/study/analysis/posterior.h"
#include "engine/study/analysis/summaries.h"
#include "engine/study/methods/psychometric_function.h"

#include <algorithm>
#include <cmath>

namespace springdrive::study {

Outcome answer_of(const PsychometricFunction &observer, double level, RandomKey key) {
    const Scale scale = observer.family.scale;
    const double z = standard_normal(child(key, 1));
    return {uniform(child(key, 0)) < proportion_at(observer, level),
            level_from(scale, on_scale(scale, observer.threshold) + z / observer.slope), false};
}

std::vector<PastMethodTrial> simulated_trials(const Method &method,
                                              const PsychometricFunction &observer, RandomKey key) {
    MethodRun run(method, child(key, 0));
    std::vector<PastMethodTrial> trials;
    while (const std::optional<MethodTrial> trial = run.next()) {
        const RandomKey of_answer = child(child(key, 1), static_cast<std::uint64_t>(trials.size()));
        trials.push_back({*trial, answer_of(observer, trial->level, of_answer)});
        run.add(trials.back());
    }
    return trials;
}

namespace {

/// The interval of one study's threshold and its truth, on the scale.
struct Estimated {
    double median = 0.0;
    double low = 0.0;
    double high = 0.0;
    double truth = 0.0;
};

Estimated estimated(const PrecisionQuestion &question, std::span<const PastMethodTrial> trials,
                    const PsychometricFunction &truth) {
    const Scale scale = question.analysis.family.scale;
    const double u = on_scale(scale, truth.threshold);
    if (const auto *adjustment = std::get_if<Adjustment>(&question.method)) {
        const MeanSummary mean = settings_on_scale(*adjustment, trials).value();
        return {mean.mean, mean.low, mean.high, u};
    }
    const PosteriorSummary threshold =
        Posterior(counted(trials), question.analysis).of(FunctionParameter::threshold);
    return {on_scale(scale, threshold.median), on_scale(scale, threshold.low),
            on_scale(scale, threshold.high), u};
}

/// The value that a share of them does not exceed.
double sorted_quantile(std::vector<double> values, double share) {
    std::ranges::sort(values);
    const auto last = static_cast<double>(values.size() - 1);
    return values[static_cast<std::size_t>(std::ceil(share * last))];
}

Precision precision_of(int trials, std::span<const Estimated> studies) {
    Precision precision;
    precision.trials = trials;
    std::vector<double> widths;
    const auto count = static_cast<double>(studies.size());
    for (const Estimated &study : studies) {
        const double error = study.median - study.truth;
        widths.push_back(study.high - study.low);
        precision.bias += error / count;
        precision.rms_error += error * error / count;
        precision.coverage +=
            study.low <= study.truth && study.truth <= study.high ? 1.0 / count : 0.0;
    }
    precision.rms_error = std::sqrt(precision.rms_error);
    precision.median_width = sorted_quantile(widths, 0.5);
    precision.width_of_most = sorted_quantile(widths, 0.8);
    return precision;
}

Method with_method_trials(ConstantStimuli method, int trials) {
    const int in_block = static_cast<int>(method.levels.size()) * method.repetitions;
    method.blocks = (trials + in_block - 1) / in_block;
    return method;
}

Method with_method_trials(Staircases method, int trials) {
    const int tracks = static_cast<int>(method.start_levels.size());
    method.trials = (trials + tracks - 1) / tracks;
    method.reversals = 0;
    return method;
}

Method with_method_trials(QuestPlus method, int trials) {
    method.min_trials = method.max_trials = trials;
    method.threshold_deviation = 0.0;
    return method;
}

Method with_method_trials(Adjustment method, int trials) {
    method.settings = trials;
    return method;
}

} // namespace

Method with_trials(const Method &method, int trials) {
    return std::visit([trials](const auto &one) { return with_method_trials(one, trials); },
                      method);
}

std::string validate(const PrecisionQuestion &question, const Task &task) {
    const std::vector<double> trials(question.trials.begin(), question.trials.end());
    std::string error =
        first_of({validate(question.method, task), validate(question.analysis),
                  validate(question.observers), unless_rising("trials", trials, 1),
                  unless_from_to("trials (each)", trials.empty() ? 0.0 : trials.front(), 2, 10000),
                  unless_from_to("trials (each)", trials.empty() ? 0.0 : trials.back(), 2, 10000),
                  unless_from_to("studies", question.studies, 1, 1e6)});
    return error;
}

std::vector<Precision> precision_by_trials(const PrecisionQuestion &question) {
    const Method longest = with_trials(question.method, question.trials.back());
    const auto studies = static_cast<std::size_t>(question.studies);
    std::vector<std::vector<Estimated>> by_trials(question.trials.size(),
                                                  std::vector<Estimated>(studies));
    // What a method presents does not depend on how many trials will follow, so that one long study
    // gives all shorter ones.
    for_each_in_parallel(studies, all_processors(), [&](std::size_t i) {
        const RandomKey key = key_of(question.seed, static_cast<int>(i) + 1);
        const PsychometricFunction truth = drawn_function(question.observers, child(key, 0));
        const std::vector<PastMethodTrial> trials = simulated_trials(longest, truth, child(key, 1));
        for (std::size_t row = 0; row < question.trials.size(); ++row) {
            const auto first =
                std::min(trials.size(), static_cast<std::size_t>(question.trials[row]));
            by_trials[row][i] = estimated(question, std::span(trials).first(first), truth);
        }
    });
    std::vector<Precision> rows;
    for (std::size_t row = 0; row < question.trials.size(); ++row) {
        rows.push_back(precision_of(question.trials[row], by_trials[row]));
    }
    return rows;
}

std::optional<double> trials_for_width(std::span<const Precision> rows, double width) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
        if (rows[i].width_of_most > width) {
            continue;
        }
        if (i == 0) {
            return rows[0].trials;
        }
        const double before = rows[i - 1].width_of_most;
        const double part = (before - width) / (before - rows[i].width_of_most);
        return std::exp(std::lerp(std::log(rows[i - 1].trials), std::log(rows[i].trials), part));
    }
    return std::nullopt;
}

} // namespace springdrive::study
