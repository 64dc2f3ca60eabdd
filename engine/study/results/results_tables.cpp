#include "engine/study/results/results_tables.h"

#include "engine/study/conduct/sequence.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::study {

namespace {

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
