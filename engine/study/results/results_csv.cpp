#include "engine/study/results/results_csv.h"

#include "base/print.h"
#include "engine/study/conduct/stored_trial.h"

#include <optional>
#include <string>

namespace springdrive::study {

namespace {

/// A line of cells.
class CsvRow {
public:
    CsvRow &add(std::string_view text) { return add_cell(csv_cell(text)); }
    CsvRow &add(double number) { return add_cell(csv_cell(number)); }
    CsvRow &add(int number) { return add_cell(std::to_string(number)); }
    template <typename Number> CsvRow &add(const std::optional<Number> &number) {
        return number ? add(*number) : add_cell("");
    }
    CsvRow &add(const PosteriorSummary &of) { return add(of.median).add(of.low).add(of.high); }
    /// An end that the trials do not exclude is not known.
    CsvRow &add(const ProfileInterval &interval) {
        return add(interval.is_low_open ? std::nullopt : std::optional(interval.low))
            .add(interval.is_high_open ? std::nullopt : std::optional(interval.high));
    }
    CsvRow &skip(int cells) {
        for (int i = 0; i < cells; ++i) {
            add_cell("");
        }
        return *this;
    }
    void write(std::ostream &out) const { out << line_ << '\n'; }

private:
    CsvRow &add_cell(const std::string &cell) {
        line_ += (is_first_ ? "" : ",") + cell;
        is_first_ = false;
        return *this;
    }
    std::string line_;
    bool is_first_ = true;
};

CsvRow row_of(const Protocol &protocol, const SeriesResult &result) {
    CsvRow row;
    row.add(std::string_view(result.series.participant))
        .add(std::string_view(protocol.conditions[result.series.condition].name));
    return row;
}

void add_fit(CsvRow &row, const FittedFunction &fit) {
    row.add(fit.threshold).add(fit.slope).add(fit.lapse).add(fit.guess);
    row.add(fit.likelihood.function.threshold)
        .add(fit.likelihood_threshold)
        .add(fit.likelihood.function.slope)
        .add(fit.likelihood_slope)
        .add(fit.likelihood.function.lapse)
        .add(fit.goodness.deviance)
        .add(fit.goodness.p_value);
    row.add(fit.goodness.degrees_of_freedom > 0 ? std::optional(fit.goodness.dispersion)
                                                : std::nullopt);
}

} // namespace

void write_thresholds_csv(std::ostream &out, const Protocol &protocol,
                          const StudyResults &results) {
    out << "participant,number,condition,device,level_name,trials,marked,threshold,threshold_low,"
           "threshold_high,slope,slope_low,slope_high,lapse,lapse_low,lapse_high,guess,guess_low,"
           "guess_high,likelihood_threshold,likelihood_threshold_low,likelihood_threshold_high,"
           "likelihood_slope,likelihood_slope_low,likelihood_slope_high,likelihood_lapse,deviance,"
           "deviance_p,dispersion,weber_fraction,setting,setting_low,setting_high,"
           "median_response_s,catch_trials,catch_right\n";
    for (const SeriesResult &result : results.series) {
        CsvRow row;
        row.add(std::string_view(result.series.participant)).add(result.series.number);
        row.add(std::string_view(protocol.conditions[result.series.condition].name));
        row.add(name_of(results.device)).add(std::string_view(level_name_of(protocol)));
        row.add(result.trials).add(result.marked);
        if (result.fitted) {
            add_fit(row, *result.fitted);
        } else {
            constexpr int kCellsOfFit = 22;
            row.skip(kCellsOfFit);
        }
        row.add(result.weber_fraction);
        if (result.settings) {
            row.add(result.settings->mean).add(result.settings->low).add(result.settings->high);
        } else {
            row.skip(3);
        }
        row.add(result.median_response_s)
            .add(result.series.catch_trials)
            .add(result.series.catch_right)
            .write(out);
    }
}

void write_group_csv(std::ostream &out, const Protocol &protocol, const StudyResults &results) {
    out << "condition,device,level_name,participants,mean,mean_low,mean_high,scale,"
           "deviation_between_on_scale,heterogeneity\n";
    for (const ConditionSummary &summary : results.conditions) {
        CsvRow()
            .add(std::string_view(protocol.conditions[summary.condition].name))
            .add(name_of(results.device))
            .add(std::string_view(level_name_of(protocol)))
            .add(summary.on_scale.participants)
            .add(summary.mean)
            .add(summary.on_scale.participants > 1 ? std::optional(summary.low) : std::nullopt)
            .add(summary.on_scale.participants > 1 ? std::optional(summary.high) : std::nullopt)
            .add(results.family.scale == Scale::linear ? std::string_view("linear")
                                                       : std::string_view("logarithmic"))
            .add(summary.on_scale.deviation_between)
            .add(summary.on_scale.heterogeneity)
            .write(out);
    }
}

void write_levels_csv(std::ostream &out, const Protocol &protocol, const StudyResults &results) {
    out << "participant,condition,level,trials,positive\n";
    for (const SeriesResult &result : results.series) {
        for (const LevelCount &count : result.counts) {
            row_of(protocol, result)
                .add(count.level)
                .add(count.trials)
                .add(count.positive)
                .write(out);
        }
    }
}

void write_functions_csv(std::ostream &out, const Protocol &protocol, const StudyResults &results) {
    out << "participant,condition,level,proportion,proportion_low,proportion_high,"
           "likelihood_proportion\n";
    for (const SeriesResult &result : results.series) {
        if (!result.fitted) {
            continue;
        }
        for (const FunctionPoint &point : result.fitted->course) {
            row_of(protocol, result)
                .add(point.level)
                .add(point.proportion)
                .add(point.low)
                .add(point.high)
                .add(point.likelihood_proportion)
                .write(out);
        }
    }
}

void write_traces_csv(std::ostream &out, const Protocol &protocol, const StudyResults &results) {
    out << "participant,condition,block,trial,track,level,positive,setting,marked,reversal,"
           "threshold,threshold_low,threshold_high\n";
    const bool sets = protocol.task.kind == TaskKind::adjustment;
    for (const SeriesResult &result : results.series) {
        for (const TracePoint &point : result.trace) {
            const bool answered = !point.outcome.marked;
            row_of(protocol, result)
                .add(point.block)
                .add(point.trial)
                .add(point.track + 1)
                .add(point.level)
                .add(answered && !sets ? std::optional(point.outcome.positive ? 1 : 0)
                                       : std::nullopt)
                .add(answered && sets ? std::optional(point.outcome.setting) : std::nullopt)
                .add(point.outcome.marked ? 1 : 0)
                .add(point.is_reversal ? 1 : 0)
                .add(point.threshold)
                .add(point.threshold_low)
                .add(point.threshold_high)
                .write(out);
        }
    }
}

} // namespace springdrive::study
