#include "engine/study/results/series_result.h"

#include "engine/study/protocol/analysis_plan.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <utility>
#include <variant>

namespace springdrive::study {

namespace {

/// What is drawn to judge a fit: the same each time, and another for each series.
RandomKey goodness_key(const Protocol &protocol, const Series &series) {
    return child(key_of(static_cast<std::uint64_t>(protocol.seed), series.number),
                 series.condition);
}

/// Where F has a value: the 95 % interval of the level, on the scale.
struct LevelInterval {
    double core = 0.5; ///< F
    double low = 0.0;
    double high = 0.0;
};

std::vector<LevelInterval> level_intervals(const Posterior &posterior, Scale scale) {
    constexpr int kIntervals = 50;
    std::vector<LevelInterval> all;
    for (int i = 0; i < kIntervals; ++i) {
        // Closer together where the function is flat: F = (1 − cos t)/2, without its ends.
        const double core = 0.5 * (1.0 - std::cos(std::numbers::pi * (i + 0.5) / kIntervals));
        const PosteriorSummary level = posterior.of_level_at(core);
        all.push_back({core, on_scale(scale, level.low), on_scale(scale, level.high)});
    }
    return all;
}

/// The F at which an end of the interval is u, interpolated. F rises with the level, so that the
/// level at F is below u where F(u) is above F: the upper ends of levels are the lower ones of F.
double core_where(const std::vector<LevelInterval> &intervals, double LevelInterval::*end,
                  double u) {
    const auto above = std::ranges::upper_bound(intervals, u, {}, end);
    if (above == intervals.begin()) {
        return 0.0;
    }
    if (above == intervals.end()) {
        return 1.0;
    }
    const LevelInterval &below = *(above - 1);
    const double part = (u - below.*end) / ((*above).*end - below.*end);
    return std::lerp(below.core, above->core, part);
}

/// From the lowest to the highest of all levels, and a tenth of their span more on either side.
std::vector<double> drawn_levels(const Protocol &protocol, Scale scale) {
    std::vector<double> on_scales;
    for (const double level : presentable_levels(protocol)) {
        if (scale == Scale::linear || level > 0.0) {
            on_scales.push_back(on_scale(scale, level));
        }
    }
    const auto [lowest, highest] = std::ranges::minmax(on_scales);
    constexpr int kLevels = 90;
    std::vector<double> levels;
    for (int i = 0; i <= kLevels; ++i) {
        const double part = -0.1 + 1.2 * i / kLevels;
        levels.push_back(level_from(scale, std::lerp(lowest, highest, part)));
    }
    return levels;
}

std::vector<FunctionPoint> course_of(const Protocol &protocol, const FittedFunction &fit,
                                     const Posterior &posterior) {
    const PsychometricFunction &function = fit.function;
    const Scale scale = function.family.scale;
    const std::vector<LevelInterval> intervals = level_intervals(posterior, scale);
    const auto proportion = [&function](double core) {
        return function.guess + (1.0 - function.guess - function.lapse) * core;
    };
    std::vector<FunctionPoint> course;
    for (const double level : drawn_levels(protocol, scale)) {
        const double u = on_scale(scale, level);
        course.push_back({level, proportion_at(function, level),
                          proportion(core_where(intervals, &LevelInterval::high, u)),
                          proportion(core_where(intervals, &LevelInterval::low, u)),
                          proportion_at(fit.likelihood.function, level)});
    }
    return course;
}

FittedFunction fitted(const Protocol &protocol, const Series &series,
                      std::span<const LevelCount> counts) {
    const FunctionPriors priors = analysis_priors(protocol);
    const Posterior posterior(counts, priors);
    FittedFunction all;
    all.threshold = posterior.of(FunctionParameter::threshold);
    all.slope = posterior.of(FunctionParameter::slope);
    all.lapse = posterior.of(FunctionParameter::lapse);
    all.guess = posterior.of(FunctionParameter::guess);
    all.function = {priors.family, all.threshold.median, all.slope.median, all.guess.median,
                    all.lapse.median};
    all.likelihood = maximum_likelihood(counts, priors);
    all.likelihood_threshold = profile_interval(counts, priors, FunctionParameter::threshold);
    all.likelihood_slope = profile_interval(counts, priors, FunctionParameter::slope);
    all.goodness = goodness_of_fit(all.likelihood, counts, priors, goodness_key(protocol, series));
    all.course = course_of(protocol, all, posterior);
    return all;
}

std::optional<SettingsResult> settings_of(const Adjustment &method,
                                          std::span<const PastMethodTrial> trials) {
    const std::optional<MeanSummary> mean = settings_on_scale(method, trials);
    if (!mean) {
        return std::nullopt;
    }
    const auto level = [&method](double u) { return level_from(method.scale, u); };
    return SettingsResult{level(mean->mean), level(mean->low), level(mean->high),
                          mean->standard_error, mean->deviation};
}

std::optional<double> median_response_s(const Series &series) {
    std::vector<double> times;
    for (const MethodTrials &run : series.runs) {
        for (const Trial &trial : run.trials) {
            if (counts(trial) && trial.response_time_s) {
                times.push_back(*trial.response_time_s);
            }
        }
    }
    if (times.empty()) {
        return std::nullopt;
    }
    std::ranges::sort(times);
    return 0.5 * (times[(times.size() - 1) / 2] + times[times.size() / 2]);
}

int marked_trials(const Series &series) {
    int marked = 0;
    for (const MethodTrials &run : series.runs) {
        marked += static_cast<int>(std::ranges::count_if(
            run.trials, [](const Trial &trial) { return !trial.marks.empty(); }));
    }
    return marked;
}

} // namespace

std::optional<double> weber_fraction_of(const Protocol &protocol, double threshold) {
    const bool is_of_one_condition = protocol.variable.standard_condition.empty();
    const bool is_eta = protocol.variable.parameter == "eta";
    const auto felt = [is_eta](double value) { return is_eta ? 1.0 - value : value; };
    const double standard = felt(protocol.variable.standard);
    if (!is_forced_choice(protocol.task.kind) || !is_of_one_condition || standard == 0.0) {
        return std::nullopt;
    }
    return std::abs(weber_fraction(felt(value_at(protocol, threshold)), standard));
}

SeriesResult result_of(const Protocol &protocol, Series series) {
    SeriesResult result;
    const std::vector<PastMethodTrial> trials = counting_trials(protocol, series);
    result.trials = static_cast<int>(trials.size());
    result.marked = marked_trials(series);
    result.median_response_s = median_response_s(series);
    if (const auto *adjustment = std::get_if<Adjustment>(&protocol.method)) {
        result.settings = settings_of(*adjustment, trials);
    } else if (!trials.empty()) {
        result.counts = counted(trials);
        result.fitted = fitted(protocol, series, result.counts);
        result.weber_fraction = weber_fraction_of(protocol, result.fitted->threshold.median);
    }
    result.trace = trace_of(protocol, series);
    result.reversals = reversals_of(protocol, series);
    result.series = std::move(series);
    return result;
}

} // namespace springdrive::study
