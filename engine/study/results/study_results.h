// What a study's trials say: series, their fits and traces, and groups.
#pragma once

#include "base/for_persons.h"
#include "base/table.h"
#include "engine/study/analysis/maximum_likelihood.h"
#include "engine/study/analysis/posterior.h"
#include "engine/study/analysis/summaries.h"
#include "engine/study/methods/psychometric_function.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/store/study_contents.h"

#include <array>
#include <cstddef>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::study {

/// Trials of one run of the method: those of one block, without practice and catch trials.
struct MethodTrials {
    int block = 1; ///< as in `TrialPlace`
    std::vector<Trial> trials;
};

/// The trials of one participant in one condition.
struct Series {
    std::string participant;
    int number = 1;            ///< of the participant
    std::size_t condition = 0; ///< index into `Protocol::conditions`
    /// A condition that is in more than one block has as many: each begins the method anew.
    std::vector<MethodTrials> runs;
    int catch_trials = 0; ///< that were not marked
    int catch_right = 0;  ///< in a forced choice, right; else answered with "yes"
};

/// By participant and, within one, in the protocol's order; those without trials are left out.
/// @param device  only trials of sessions on this kind
[[nodiscard]] std::vector<Series> series_of(const Protocol &protocol, const StudyContents &contents,
                                            DeviceKind device);

/// As the method saw it.
[[nodiscard]] PastMethodTrial method_trial(const Protocol &protocol, const Trial &trial);

/// Those that count for the analysis, of all runs.
[[nodiscard]] std::vector<PastMethodTrial> counting_trials(const Protocol &protocol,
                                                           const Series &series);

struct TracePoint {
    int block = 1;
    int trial = 1; ///< of the condition in the block, marked ones too
    int track = 0; ///< of staircases, else 0
    double level = 0.0;
    Outcome outcome;
    bool is_reversal = false; ///< of a staircase
    /// Of QUEST+, after this trial: the mean of the threshold, and a standard deviation of its
    /// posterior on either side.
    std::optional<double> threshold;
    std::optional<double> threshold_low;
    std::optional<double> threshold_high;
};

/// Trials of a block that ended up on another kind of device are not in the series; the method is
/// then not replayed, and the points have levels and answers only.
[[nodiscard]] std::vector<TracePoint> trace_of(const Protocol &protocol, const Series &series);

struct TrackEstimate {
    int block = 1;
    int track = 0;
    ReversalEstimate estimate;
};

/// Of staircases: tracks that turned often enough. Reversals before the last change of the step's
/// size are left out. Empty for other methods.
[[nodiscard]] std::vector<TrackEstimate> reversals_of(const Protocol &protocol,
                                                      const Series &series);

/// A point of the fitted functions, for drawing.
struct FunctionPoint {
    double level = 0.0;
    double proportion = 0.0; ///< of positive answers, by `FittedFunction::function`
    double low = 0.0; ///< of the posterior's interval of F there, with its guesses and lapses
    double high = 0.0;
    double likelihood_proportion = 0.0; ///< by maximum likelihood
};

/// A psychometric function, by both ways of docs/study_methods.md; intervals hold 95 %.
struct FittedFunction {
    PosteriorSummary threshold;
    PosteriorSummary slope;
    PosteriorSummary lapse;
    PosteriorSummary guess;
    PsychometricFunction function;     ///< with the posterior's medians
    std::vector<FunctionPoint> course; ///< over all levels that can be presented, and a tenth more
    LikelihoodFit likelihood;
    ProfileInterval likelihood_threshold;
    ProfileInterval likelihood_slope;
    GoodnessOfFit goodness;
};

/// The mean of settings, as levels: on a logarithmic scale the geometric mean.
struct SettingsResult {
    double mean = 0.0;
    double low = 0.0; ///< of Student's interval; −∞ (0) and ∞ of a single setting
    double high = 0.0;
    double standard_error_on_scale = 0.0;
    double deviation_on_scale = 0.0;
};

/// What they say.
struct SeriesResult {
    Series series;
    int trials = 0; ///< that count
    int marked = 0;
    std::vector<LevelCount> counts;         ///< empty of an adjustment
    std::optional<FittedFunction> fitted;   ///< nothing of an adjustment, and without trials
    std::optional<SettingsResult> settings; ///< of an adjustment
    /// Of a forced choice against a standard: see `weber_fraction_of`.
    std::optional<double> weber_fraction;
    std::optional<double> median_response_s;
    std::vector<TracePoint> trace;
    std::vector<TrackEstimate> reversals;
};

/// Deterministic; a tenth of a second or so, most of it for the goodness of fit.
/// @pre validate(protocol) is empty
[[nodiscard]] SeriesResult result_of(const Protocol &protocol, Series series);

/// |comparison at threshold − standard|/standard of the parameter under test; of η the fraction of
/// 1 − η, to which the stiffness is proportional. Nothing where the standard is 0, where the
/// standard is another condition, and in tasks that are no forced choice: their threshold is where
/// both are equal, no difference that is just felt.
[[nodiscard]] std::optional<double> weber_fraction_of(const Protocol &protocol, double threshold);

/// The mean of the participants' thresholds (of an adjustment, of their mean settings) in one
/// condition: `random_effects` on the scale of the function. Participants without an estimate are
/// left out.
struct ConditionSummary {
    std::size_t condition = 0; ///< index into `Protocol::conditions`
    GroupSummary on_scale;
    double mean = 0.0; ///< as levels
    double low = 0.0;
    double high = 0.0;
};

struct StudyResults {
    DeviceKind device = DeviceKind::usb;
    FunctionFamily family; ///< that was fitted; of an adjustment only its scale
    std::vector<SeriesResult> series;
    std::vector<ConditionSummary> conditions;
};

/// Receives the share that is done, from 0 to 1, one call at a time.
using ResultsProgress = std::function<void(double)>;

/// All of them, on all processors.
/// @pre validate(protocol) is empty
[[nodiscard]] StudyResults results_of(const Protocol &protocol, const StudyContents &contents,
                                      DeviceKind device, const ResultsProgress &progress);

// Results as tables for other programs, a row for each of what is named first below. Levels and
// thresholds are in the unit of what `level_name` says.

/// Participant and condition: trials, threshold, slope and lapse rate with 95 % intervals, by
/// posterior and maximum likelihood, Weber's fraction, goodness of fit, mean settings.
[[nodiscard]] Table thresholds_table(const Protocol &protocol, const StudyResults &results);

/// Condition: the group's mean threshold.
[[nodiscard]] Table group_table(const Protocol &protocol, const StudyResults &results);

/// Participant, condition and level: trials and positive answers (right, or "yes").
[[nodiscard]] Table levels_table(const Protocol &protocol, const StudyResults &results);

/// Participant, condition and level: the proportions of the fitted functions, the posterior's with
/// its 95 % interval, and maximum likelihood's.
[[nodiscard]] Table functions_table(const Protocol &protocol, const StudyResults &results);

/// Participant, condition, block and trial: level, answer, and what the method made of them.
[[nodiscard]] Table traces_table(const Protocol &protocol, const StudyResults &results);

struct ResultsTable {
    std::string_view file; ///< its name
    Table (*make)(const Protocol &, const StudyResults &);
    void (*write)(std::ostream &, const Table &); ///< the others are for programs, to draw
};

inline constexpr std::array<ResultsTable, 5> kResultsTables{{
    {"thresholds.csv", thresholds_table, write_csv_for_persons},
    {"group.csv", group_table, write_csv_for_persons},
    {"levels.csv", levels_table, write_csv},
    {"functions.csv", functions_table, write_csv},
    {"traces.csv", traces_table, write_csv},
}};

} // namespace springdrive::study
