#include "engine/study/results/study_results.h"

#include "base/parallel.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/methods/method.h"
#include "engine/study/protocol/session_plan.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <numbers>
#include <span>
#include <utility>
#include <variant>

namespace springdrive::study {

namespace {

/// From 0; tracks are stored by their number from 1, a single one without.
int track_index(const std::string &name) {
    int number = 1;
    std::from_chars(name.data(), name.data() + name.size(), number);
    return number - 1;
}

void add_trial(const Protocol &protocol, Series &series, const Trial &trial) {
    if (trial.is_practice) {
        return;
    }
    if (trial.is_catch) {
        series.catch_trials += trial.marks.empty() ? 1 : 0;
        series.catch_right += trial.marks.empty() && outcome_of(protocol, trial).positive ? 1 : 0;
        return;
    }
    if (series.runs.empty() || series.runs.back().block != trial.place.block) {
        series.runs.push_back({trial.place.block, {}});
    }
    series.runs.back().trials.push_back(trial);
}

std::vector<PastMethodTrial> as_seen_by_method(const Protocol &protocol, const MethodTrials &run) {
    std::vector<PastMethodTrial> trials;
    for (const Trial &trial : run.trials) {
        trials.push_back(method_trial(protocol, trial));
    }
    return trials;
}

/// Whether these are the first trials of the method, without a gap: where the method decides by
/// the answers, it can be run through them again.
bool is_without_gap(const Method &method, std::span<const PastMethodTrial> trials) {
    if (const auto *staircases = std::get_if<Staircases>(&method)) {
        StaircasesRun run(*staircases, RandomKey{});
        for (const PastMethodTrial &trial : trials) {
            const auto track = static_cast<std::size_t>(trial.presented.track);
            if (track >= run.tracks().size() ||
                run.tracks()[track].level != trial.presented.level) {
                return false;
            }
            run.add(trial);
        }
        return true;
    }
    QuestPlusRun run(std::get<QuestPlus>(method));
    for (const PastMethodTrial &trial : trials) {
        const std::optional<MethodTrial> next = run.next();
        if (!next || next->level != trial.presented.level) {
            return false;
        }
        run.add(trial);
    }
    return true;
}

void add_reversals(const Staircases &method, std::span<const PastMethodTrial> trials,
                   std::span<TracePoint> points) {
    StaircasesRun run(method, RandomKey{}); // the key draws tracks, which are known by now
    for (std::size_t i = 0; i < trials.size(); ++i) {
        const auto track = static_cast<std::size_t>(trials[i].presented.track);
        const std::size_t before = run.tracks()[track].reversal_levels.size();
        run.add(trials[i]);
        points[i].is_reversal = run.tracks()[track].reversal_levels.size() > before;
    }
}

void add_estimates(const QuestPlus &method, std::span<const PastMethodTrial> trials,
                   std::span<TracePoint> points) {
    const Scale scale = method.threshold.prior.scale;
    QuestPlusRun run(method);
    for (std::size_t i = 0; i < trials.size(); ++i) {
        run.add(trials[i]);
        const double u = on_scale(scale, run.mean().threshold);
        points[i].threshold = run.mean().threshold;
        points[i].threshold_low = level_from(scale, u - run.threshold_deviation());
        points[i].threshold_high = level_from(scale, u + run.threshold_deviation());
    }
}

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

std::optional<ParticipantEstimate> estimate_of(const SeriesResult &result, Scale scale) {
    if (result.settings && result.settings->standard_error_on_scale > 0.0) {
        return ParticipantEstimate{on_scale(scale, result.settings->mean),
                                   result.settings->standard_error_on_scale};
    }
    if (result.fitted && result.fitted->threshold.deviation_on_scale > 0.0) {
        return ParticipantEstimate{on_scale(scale, result.fitted->threshold.mean),
                                   result.fitted->threshold.deviation_on_scale};
    }
    return std::nullopt;
}

std::optional<ConditionSummary> summary_of(const StudyResults &results, std::size_t condition) {
    const Scale scale = results.family.scale;
    std::vector<ParticipantEstimate> estimates;
    for (const SeriesResult &result : results.series) {
        if (result.series.condition == condition) {
            if (const std::optional<ParticipantEstimate> one = estimate_of(result, scale)) {
                estimates.push_back(*one);
            }
        }
    }
    if (estimates.empty()) {
        return std::nullopt;
    }
    const GroupSummary group = random_effects(estimates);
    return ConditionSummary{condition, group, level_from(scale, group.mean),
                            level_from(scale, group.low), level_from(scale, group.high)};
}

std::array<Cell, 3> cells_of(const PosteriorSummary &of) { return {of.median, of.low, of.high}; }

/// An end that the trials do not exclude is not known.
std::array<Cell, 2> cells_of(const ProfileInterval &interval) {
    return {interval.is_low_open ? Cell() : interval.low,
            interval.is_high_open ? Cell() : interval.high};
}

template <typename Cells> void append(std::vector<Cell> &row, const Cells &cells) {
    row.insert(row.end(), cells.begin(), cells.end());
}

constexpr std::size_t kCellsOfFit = 22;

void append_fit(std::vector<Cell> &row, const FittedFunction &fit) {
    for (const PosteriorSummary &of : {fit.threshold, fit.slope, fit.lapse, fit.guess}) {
        append(row, cells_of(of));
    }
    row.emplace_back(fit.likelihood.function.threshold);
    append(row, cells_of(fit.likelihood_threshold));
    row.emplace_back(fit.likelihood.function.slope);
    append(row, cells_of(fit.likelihood_slope));
    row.emplace_back(fit.likelihood.function.lapse);
    row.emplace_back(fit.goodness.deviance);
    row.emplace_back(fit.goodness.p_value);
    row.push_back(fit.goodness.degrees_of_freedom > 0 ? Cell(fit.goodness.dispersion) : Cell());
}

const std::string &condition_of(const Protocol &protocol, const SeriesResult &result) {
    return protocol.conditions[result.series.condition].name;
}

} // namespace

std::vector<Series> series_of(const Protocol &protocol, const StudyContents &contents,
                              DeviceKind device) {
    const std::vector<Trial> trials = trials_on(contents, device);
    std::vector<Series> all;
    for (const Participant &participant : contents.participants) {
        for (std::size_t i = 0; i < protocol.conditions.size(); ++i) {
            Series series{participant.code, participant.number, i, {}, 0, 0};
            for (const Trial &trial : trials) {
                if (trial.participant == participant.code &&
                    trial.condition == protocol.conditions[i].name) {
                    add_trial(protocol, series, trial);
                }
            }
            if (!series.runs.empty()) {
                all.push_back(std::move(series));
            }
        }
    }
    return all;
}

PastMethodTrial method_trial(const Protocol &protocol, const Trial &trial) {
    return {{trial.level.value_or(0.0), track_index(trial.track)}, outcome_of(protocol, trial)};
}

std::vector<PastMethodTrial> counting_trials(const Protocol &protocol, const Series &series) {
    std::vector<PastMethodTrial> trials;
    for (const MethodTrials &run : series.runs) {
        for (const Trial &trial : run.trials) {
            if (counts(trial)) {
                trials.push_back(method_trial(protocol, trial));
            }
        }
    }
    return trials;
}

std::vector<TracePoint> trace_of(const Protocol &protocol, const Series &series) {
    std::vector<TracePoint> points;
    for (const MethodTrials &run : series.runs) {
        const std::vector<PastMethodTrial> trials = as_seen_by_method(protocol, run);
        const std::size_t first = points.size();
        for (const PastMethodTrial &trial : trials) {
            TracePoint point;
            point.block = run.block;
            point.trial = static_cast<int>(points.size() - first) + 1;
            point.track = trial.presented.track;
            point.level = trial.presented.level;
            point.outcome = trial.outcome;
            points.push_back(point);
        }
        const auto *staircases = std::get_if<Staircases>(&protocol.method);
        const auto *quest = std::get_if<QuestPlus>(&protocol.method);
        if ((staircases == nullptr && quest == nullptr) ||
            !is_without_gap(protocol.method, trials)) {
            continue;
        }
        const std::span<TracePoint> of_run = std::span(points).subspan(first);
        if (staircases != nullptr) {
            add_reversals(*staircases, trials, of_run);
        } else {
            add_estimates(*quest, trials, of_run);
        }
    }
    return points;
}

std::vector<TrackEstimate> reversals_of(const Protocol &protocol, const Series &series) {
    const auto *method = std::get_if<Staircases>(&protocol.method);
    std::vector<TrackEstimate> all;
    if (method == nullptr) {
        return all;
    }
    for (const MethodTrials &run : series.runs) {
        const std::vector<PastMethodTrial> trials = as_seen_by_method(protocol, run);
        if (!is_without_gap(*method, trials)) {
            continue;
        }
        const std::vector<std::optional<ReversalEstimate>> estimates =
            reversal_estimates(*method, trials, method->steps.back().from_reversal);
        for (std::size_t track = 0; track < estimates.size(); ++track) {
            if (estimates[track]) {
                all.push_back({run.block, static_cast<int>(track), *estimates[track]});
            }
        }
    }
    return all;
}

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

StudyResults results_of(const Protocol &protocol, const StudyContents &contents, DeviceKind device,
                        const ResultsProgress &progress) {
    StudyResults results;
    results.device = device;
    results.family = analysis_family(protocol);
    if (const auto *adjustment = std::get_if<Adjustment>(&protocol.method)) {
        results.family.scale = adjustment->scale;
    }
    std::vector<Series> series = series_of(protocol, contents, device);
    results.series.resize(series.size());
    std::mutex counting;
    std::size_t done = 0;
    for_each_in_parallel(series.size(), all_processors(), [&](std::size_t i) {
        results.series[i] = result_of(protocol, std::move(series[i]));
        const std::scoped_lock lock(counting);
        progress(static_cast<double>(++done) / static_cast<double>(series.size()));
    });
    for (std::size_t i = 0; i < protocol.conditions.size(); ++i) {
        if (const std::optional<ConditionSummary> summary = summary_of(results, i)) {
            results.conditions.push_back(*summary);
        }
    }
    return results;
}

Table thresholds_table(const Protocol &protocol, const StudyResults &results) {
    Table table = Table::with_columns(
        "participant,number,condition,device,level_name,trials,marked,threshold,"
        "threshold_low,threshold_high,slope,slope_low,slope_high,lapse,lapse_low,"
        "lapse_high,guess,guess_low,guess_high,likelihood_threshold,"
        "likelihood_threshold_low,likelihood_threshold_high,likelihood_slope,"
        "likelihood_slope_low,likelihood_slope_high,likelihood_lapse,deviance,"
        "deviance_p,dispersion,weber_fraction,setting,setting_low,setting_high,"
        "median_response_s,catch_trials,catch_right");
    for (const SeriesResult &result : results.series) {
        const Series &series = result.series;
        std::vector<Cell> row{series.participant,
                              series.number,
                              condition_of(protocol, result),
                              name_of(results.device),
                              level_name_of(protocol),
                              result.trials,
                              result.marked};
        if (result.fitted) {
            append_fit(row, *result.fitted);
        } else {
            row.resize(row.size() + kCellsOfFit);
        }
        row.emplace_back(result.weber_fraction);
        append(row, result.settings
                        ? std::array<Cell, 3>{result.settings->mean, result.settings->low,
                                              result.settings->high}
                        : std::array<Cell, 3>{});
        append(row, std::array<Cell, 3>{result.median_response_s, series.catch_trials,
                                        series.catch_right});
        table.rows.push_back(std::move(row));
    }
    return table;
}

Table group_table(const Protocol &protocol, const StudyResults &results) {
    Table table =
        Table::with_columns("condition,device,level_name,participants,mean,mean_low,mean_high,"
                            "scale,deviation_between_on_scale,heterogeneity");
    for (const ConditionSummary &summary : results.conditions) {
        const bool has_interval = summary.on_scale.participants > 1;
        table.rows.push_back({protocol.conditions[summary.condition].name, name_of(results.device),
                              level_name_of(protocol), summary.on_scale.participants, summary.mean,
                              has_interval ? Cell(summary.low) : Cell(),
                              has_interval ? Cell(summary.high) : Cell(),
                              results.family.scale == Scale::linear ? "linear" : "logarithmic",
                              summary.on_scale.deviation_between, summary.on_scale.heterogeneity});
    }
    return table;
}

Table levels_table(const Protocol &protocol, const StudyResults &results) {
    Table table = Table::with_columns("participant,condition,level,trials,positive");
    for (const SeriesResult &result : results.series) {
        for (const LevelCount &count : result.counts) {
            table.rows.push_back({result.series.participant, condition_of(protocol, result),
                                  count.level, count.trials, count.positive});
        }
    }
    return table;
}

Table functions_table(const Protocol &protocol, const StudyResults &results) {
    Table table = Table::with_columns("participant,condition,level,proportion,proportion_low,"
                                      "proportion_high,likelihood_proportion");
    for (const SeriesResult &result : results.series) {
        if (!result.fitted) {
            continue;
        }
        for (const FunctionPoint &point : result.fitted->course) {
            table.rows.push_back({result.series.participant, condition_of(protocol, result),
                                  point.level, point.proportion, point.low, point.high,
                                  point.likelihood_proportion});
        }
    }
    return table;
}

Table traces_table(const Protocol &protocol, const StudyResults &results) {
    Table table =
        Table::with_columns("participant,condition,block,trial,track,level,positive,setting,"
                            "marked,reversal,threshold,threshold_low,threshold_high");
    const bool sets = protocol.task.kind == TaskKind::adjustment;
    for (const SeriesResult &result : results.series) {
        for (const TracePoint &point : result.trace) {
            const bool answered = !point.outcome.marked;
            table.rows.push_back({result.series.participant, condition_of(protocol, result),
                                  point.block, point.trial, point.track + 1, point.level,
                                  answered && !sets ? Cell(point.outcome.positive) : Cell(),
                                  answered && sets ? Cell(point.outcome.setting) : Cell(),
                                  point.outcome.marked, point.is_reversal, point.threshold,
                                  point.threshold_low, point.threshold_high});
        }
    }
    return table;
}

} // namespace springdrive::study
