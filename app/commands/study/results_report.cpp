#include "app/commands/study/results_report.h"

#include "base/print.h"
#include "base/table.h"
#include "engine/study/conduct/stored_trial.h"

#include <cmath>
#include <string>
#include <variant>

namespace springdrive::app {

namespace {

Cell interval(double value, double low, double high) {
    return Cell::like_number(fmt::format("{:.3g} ({:.3g} to {:.3g})", value, low, high));
}

Cell interval(double value, const study::ProfileInterval &ends) {
    return Cell::like_number(fmt::format("{:.3g} ({}{:.3g} to {:.3g}{})", value,
                                         ends.is_low_open ? "below " : "", ends.low, ends.high,
                                         ends.is_high_open ? " or more" : ""));
}

/// What the threshold is: a level at a proportion of positive answers.
std::string definition_of(const study::Protocol &protocol, const study::StudyResults &results) {
    const double core = study::core_at_threshold(results.family.shape);
    const std::string level = study::level_name_of(protocol);
    if (!study::is_forced_choice(protocol.task.kind)) {
        return fmt::format("threshold: {} at {:.0f} % \"yes\", apart from lapses and false alarms",
                           level, 100.0 * core);
    }
    const double guess = 1.0 / protocol.task.alternatives;
    return fmt::format("threshold: {} at {:.0f} % right answers, of who does not lapse", level,
                       100.0 * (guess + (1.0 - guess) * core));
}

void write_fits(std::ostream &out, const study::Protocol &protocol,
                const study::StudyResults &results) {
    print(out, "{}\n\n", definition_of(protocol, results));
    Table table = Table::with_columns("who,condition,trials,threshold (95 %),slope (95 %),"
                                      "max. likelihood,Weber:.3f,fit p:.2f,catch");
    for (const study::SeriesResult &result : results.series) {
        if (!result.fitted) {
            continue;
        }
        const study::FittedFunction &fit = *result.fitted;
        const study::Series &series = result.series;
        table.rows.push_back(
            {series.participant, protocol.conditions[series.condition].name, result.trials,
             interval(fit.threshold.median, fit.threshold.low, fit.threshold.high),
             interval(fit.slope.median, fit.slope.low, fit.slope.high),
             interval(fit.likelihood.function.threshold, fit.likelihood_threshold),
             result.weber_fraction, fit.goodness.p_value,
             series.catch_trials > 0
                 ? Cell::like_number(fmt::format("{}/{}", series.catch_right, series.catch_trials))
                 : Cell()});
    }
    write_text(out, table);
}

void write_settings(std::ostream &out, const study::Protocol &protocol,
                    const study::StudyResults &results) {
    Table table = Table::with_columns("who,condition,settings");
    table.columns.push_back({study::level_name_of(protocol) + " (95 %)"});
    for (const study::SeriesResult &result : results.series) {
        if (result.settings) {
            table.rows.push_back(
                {result.series.participant, protocol.conditions[result.series.condition].name,
                 result.trials,
                 interval(result.settings->mean, result.settings->low, result.settings->high)});
        }
    }
    write_text(out, table);
}

void write_reversals(std::ostream &out, const study::Protocol &protocol,
                     const study::StudyResults &results) {
    const auto *method = std::get_if<study::Staircases>(&protocol.method);
    if (method == nullptr) {
        return;
    }
    print(out, "\nmean of reversals, which converges to {:.1f} % right answers\n",
          100.0 * study::convergence_proportion(*method));
    Table table = Table::with_columns("who,condition,track,mean:.3g,reversals");
    for (const study::SeriesResult &result : results.series) {
        for (const study::TrackEstimate &track : result.reversals) {
            table.rows.push_back({result.series.participant,
                                  protocol.conditions[result.series.condition].name,
                                  track.track + 1, track.estimate.level, track.estimate.reversals});
        }
    }
    write_text(out, table);
}

void write_groups(std::ostream &out, const study::Protocol &protocol,
                  const study::StudyResults &results) {
    const bool are_ratios = results.family.scale == study::Scale::logarithmic;
    Table table =
        Table::with_columns("group,condition,participants,mean (95 %):.3g,deviation between:.3g");
    if (are_ratios) {
        table.columns.back().name += ", factor";
    }
    for (const study::ConditionSummary &group : results.conditions) {
        const double between = group.on_scale.deviation_between;
        table.rows.push_back(
            {"", protocol.conditions[group.condition].name, group.on_scale.participants,
             group.on_scale.participants > 1 ? interval(group.mean, group.low, group.high)
                                             : Cell(group.mean),
             are_ratios ? std::exp(between) : between});
    }
    out << '\n';
    write_text(out, table);
}

} // namespace

void write_results(std::ostream &out, const study::Protocol &protocol,
                   const study::StudyResults &results) {
    print(out, "{}\n", protocol.title);
    if (results.device != study::DeviceKind::usb) {
        print(out, "data of {} devices: no person's\n", study::name_of(results.device));
    }
    if (protocol.task.kind == study::TaskKind::adjustment) {
        write_settings(out, protocol, results);
    } else {
        write_fits(out, protocol, results);
        write_reversals(out, protocol, results);
    }
    write_groups(out, protocol, results);
}

} // namespace springdrive::app
