#include "app/commands/study/results_report.h"

#include "base/print.h"
#include "engine/study/conduct/stored_trial.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <variant>

namespace springdrive::app {

namespace {

constexpr int kLeastWidth = 9; ///< of the column of conditions

std::string interval_text(double value, double low, double high) {
    return fmt::format("{:.3g} ({:.3g} to {:.3g})", value, low, high);
}

std::string interval_text(double value, const study::ProfileInterval &interval) {
    return fmt::format("{:.3g} ({}{:.3g} to {:.3g}{})", value, interval.is_low_open ? "below " : "",
                       interval.low, interval.high, interval.is_high_open ? " or more" : "");
}

/// Characters, not bytes.
int letters_in(const std::string &text) {
    return static_cast<int>(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

int width_of_names(const study::Protocol &protocol) {
    int width = kLeastWidth;
    for (const study::Condition &condition : protocol.conditions) {
        width = std::max(width, letters_in(condition.name));
    }
    return width;
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
    const int width = width_of_names(protocol);
    print(out, "{}\n\n", definition_of(protocol, results));
    print(out, "{:<4}  {:<{}} {:>6} {:>26} {:>24} {:>26} {:>6} {:>6} {:>6}\n", "who", "condition",
          width, "trials", "threshold (95 %)", "slope (95 %)", "max. likelihood", "Weber", "fit p",
          "catch");
    for (const study::SeriesResult &result : results.series) {
        if (!result.fitted) {
            continue;
        }
        const study::FittedFunction &fit = *result.fitted;
        const study::Series &series = result.series;
        print(out, "{:<4}  {:<{}} {:>6} {:>26} {:>24} {:>26} {:>6} {:>6.2f} {:>6}\n",
              series.participant, protocol.conditions[series.condition].name, width, result.trials,
              interval_text(fit.threshold.median, fit.threshold.low, fit.threshold.high),
              interval_text(fit.slope.median, fit.slope.low, fit.slope.high),
              interval_text(fit.likelihood.function.threshold, fit.likelihood_threshold),
              result.weber_fraction ? fmt::format("{:.3f}", *result.weber_fraction)
                                    : std::string("-"),
              fit.goodness.p_value,
              series.catch_trials > 0
                  ? fmt::format("{}/{}", series.catch_right, series.catch_trials)
                  : std::string("-"));
    }
}

void write_settings(std::ostream &out, const study::Protocol &protocol,
                    const study::StudyResults &results) {
    const int width = width_of_names(protocol);
    print(out, "{:<4}  {:<{}} {:>8} {:>26}\n", "who", "condition", width, "settings",
          study::level_name_of(protocol) + " (95 %)");
    for (const study::SeriesResult &result : results.series) {
        if (result.settings) {
            print(
                out, "{:<4}  {:<{}} {:>8} {:>26}\n", result.series.participant,
                protocol.conditions[result.series.condition].name, width, result.trials,
                interval_text(result.settings->mean, result.settings->low, result.settings->high));
        }
    }
}

void write_reversals(std::ostream &out, const study::Protocol &protocol,
                     const study::StudyResults &results) {
    const auto *method = std::get_if<study::Staircases>(&protocol.method);
    if (method == nullptr) {
        return;
    }
    print(out, "\nmean of reversals, which converges to {:.1f} % right answers\n",
          100.0 * study::convergence_proportion(*method));
    const int width = width_of_names(protocol);
    for (const study::SeriesResult &result : results.series) {
        for (const study::TrackEstimate &track : result.reversals) {
            print(out, "{:<4}  {:<{}} track {}: {:.3g}, of {} reversals\n",
                  result.series.participant, protocol.conditions[result.series.condition].name,
                  width, track.track + 1, track.estimate.level, track.estimate.reversals);
        }
    }
}

void write_groups(std::ostream &out, const study::Protocol &protocol,
                  const study::StudyResults &results) {
    const int width = width_of_names(protocol);
    const bool are_ratios = results.family.scale == study::Scale::logarithmic;
    print(out, "\n{:<5} {:<{}} {:>12} {:>26} {:>27}\n", "group", "condition", width, "participants",
          "mean (95 %)", are_ratios ? "deviation between, factor" : "deviation between");
    for (const study::ConditionSummary &group : results.conditions) {
        const double between = group.on_scale.deviation_between;
        print(out, "{:<5} {:<{}} {:>12} {:>26} {:>27.3g}\n", "",
              protocol.conditions[group.condition].name, width, group.on_scale.participants,
              group.on_scale.participants > 1 ? interval_text(group.mean, group.low, group.high)
                                              : fmt::format("{:.3g}", group.mean),
              are_ratios ? std::exp(between) : between);
    }
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
