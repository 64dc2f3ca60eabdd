#include "app/commands/study/study_pictures.h"

#include "app/host/asset_folder.h"
#include "engine/study/conduct/conduct.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <variant>

namespace springdrive::app {

namespace {

Chart chart_of(std::string_view script, const ChartMarks &marks,
               const std::filesystem::path &folder, std::string csv, std::string svg,
               std::string second_csv = {}) {
    return {asset_folder() / "figures" / script,
            marks.assignments(),
            folder,
            std::move(csv),
            std::move(svg),
            std::move(second_csv)};
}

/// "turn_deg [°]"
std::string level_label(const study::Protocol &protocol) {
    const std::string unit(study::variable_of(protocol).unit);
    return study::level_name_of(protocol) + (unit == "–" ? std::string() : " [" + unit + "]");
}

/// Rows of a table, from 0 without its header, that are drawn in one panel.
struct Rows {
    std::size_t first = 0;
    std::size_t count = 0;
};

void add_rows(ChartMarks &marks, const std::string &name, std::size_t panel, const Rows &rows) {
    marks.add(fmt::format("{}_first_{}", name, panel), static_cast<double>(rows.first));
    marks.add(fmt::format("{}_last_{}", name, panel),
              static_cast<double>(rows.first + rows.count) - 1.0);
}

struct Heading {
    std::string title;
    std::string note; ///< below it
};

void add_common(ChartMarks &marks, const study::Protocol &protocol,
                const study::StudyResults &results, const Heading &heading) {
    const std::string device =
        results.device == study::DeviceKind::usb
            ? std::string()
            : fmt::format("{} device, no person's data; ", study::name_of(results.device));
    marks.add("heading", heading.title);
    marks.add("note", device + heading.note);
    marks.add("level_label", level_label(protocol));
    marks.add("is_logarithmic", results.family.scale == study::Scale::logarithmic ? 1.0 : 0.0);
}

/// Where each series is in the tables.
struct SeriesRows {
    const study::SeriesResult *result = nullptr;
    Rows functions;
    Rows levels;
    std::vector<Rows> traces; ///< by run of the method
};

std::vector<SeriesRows> rows_of(const study::StudyResults &results) {
    std::vector<SeriesRows> all;
    SeriesRows next;
    std::size_t traced = 0;
    for (const study::SeriesResult &result : results.series) {
        next.result = &result;
        next.functions.count = result.fitted ? result.fitted->course.size() : 0;
        next.levels.count = result.counts.size();
        next.traces.clear();
        for (const study::MethodTrials &run : result.series.runs) {
            next.traces.push_back({traced, run.trials.size()});
            traced += run.trials.size();
        }
        all.push_back(next);
        next.functions.first += next.functions.count;
        next.levels.first += next.levels.count;
    }
    return all;
}

Chart functions_picture(const study::Protocol &protocol, const study::StudyResults &results,
                        const std::filesystem::path &folder, const std::string &participant,
                        const std::vector<SeriesRows> &series) {
    ChartMarks marks;
    add_common(marks, protocol, results,
               {fmt::format("Participant {}: {}", participant, protocol.title),
                "area of a point: its number of trials; band: 95 % of the posterior"});
    marks.add("answers_label",
              study::is_forced_choice(protocol.task.kind) ? "right answers" : "answers \"yes\"");
    marks.add("chance", study::guess_range(protocol.task).minimum);
    int most = 1;
    std::size_t panel = 0;
    for (const SeriesRows &rows : series) {
        if (!rows.result->fitted) {
            continue;
        }
        ++panel;
        for (const study::LevelCount &count : rows.result->counts) {
            most = std::max(most, count.trials);
        }
        const study::FittedFunction &fit = *rows.result->fitted;
        marks.add(fmt::format("title_{}", panel),
                  protocol.conditions[rows.result->series.condition].name);
        marks.add(fmt::format("threshold_text_{}", panel),
                  fmt::format("threshold {:.3g} ({:.3g} to {:.3g}), {} trials",
                              fit.threshold.median, fit.threshold.low, fit.threshold.high,
                              rows.result->trials));
        marks.add(fmt::format("threshold_low_{}", panel), fit.threshold.low);
        marks.add(fmt::format("threshold_{}", panel), fit.threshold.median);
        marks.add(fmt::format("threshold_high_{}", panel), fit.threshold.high);
        marks.add("lowest", fit.course.front().level);
        marks.add("highest", fit.course.back().level);
        add_rows(marks, "functions", panel, rows.functions);
        add_rows(marks, "levels", panel, rows.levels);
    }
    marks.add("panels", static_cast<double>(panel));
    marks.add("most_trials", most);
    return chart_of("study_functions.gnuplot", marks, folder, "functions.csv",
                    "functions_" + participant + ".svg", "levels.csv");
}

Chart traces_picture(const study::Protocol &protocol, const study::StudyResults &results,
                     const std::filesystem::path &folder, const std::string &participant,
                     const std::vector<SeriesRows> &series) {
    const auto *staircases = std::get_if<study::Staircases>(&protocol.method);
    const bool is_adjustment = std::holds_alternative<study::Adjustment>(protocol.method);
    ChartMarks marks;
    add_common(marks, protocol, results,
               {fmt::format("Participant {}: {}", participant, protocol.title),
                is_adjustment ? "a point a setting" : "a point a trial"});
    marks.add("tracks",
              staircases == nullptr ? 0.0 : static_cast<double>(staircases->start_levels.size()));
    marks.add("is_adjustment", is_adjustment ? 1.0 : 0.0);
    std::size_t panel = 0;
    for (const SeriesRows &rows : series) {
        const study::Series &of = rows.result->series;
        for (std::size_t run = 0; run < rows.traces.size(); ++run) {
            ++panel;
            marks.add(fmt::format("title_{}", panel),
                      protocol.conditions[of.condition].name +
                          (of.runs.size() > 1 ? fmt::format(", block {}", of.runs[run].block)
                                              : std::string()));
            add_rows(marks, "traces", panel, rows.traces[run]);
        }
    }
    marks.add("panels", static_cast<double>(panel));
    return chart_of("study_traces.gnuplot", marks, folder, "traces.csv",
                    "traces_" + participant + ".svg");
}

Chart group_picture(const study::Protocol &protocol, const study::StudyResults &results,
                    const std::filesystem::path &folder) {
    const bool is_adjustment = std::holds_alternative<study::Adjustment>(protocol.method);
    ChartMarks marks;
    add_common(marks, protocol, results,
               {protocol.title, "bars: 95 % intervals; mean of random effects"});
    marks.add("estimate_label", is_adjustment ? "mean setting: " : "threshold: ");
    int most = 1;
    std::string participants; // words: panel, number, estimate and its interval
    for (const study::SeriesResult &result : results.series) {
        most = std::max(most, result.series.number);
        const auto panel = std::ranges::find(results.conditions, result.series.condition,
                                             &study::ConditionSummary::condition) -
                           results.conditions.begin() + 1;
        const auto append = [&](double estimate, double low, double high) {
            participants += fmt::format("{} {} {:.17g} {:.17g} {:.17g} ", panel,
                                        result.series.number, estimate, low, high);
        };
        if (result.settings) {
            append(result.settings->mean, result.settings->low, result.settings->high);
        } else if (result.fitted) {
            const auto &threshold = result.fitted->threshold;
            append(threshold.median, threshold.low, threshold.high);
        }
    }
    marks.add("highest_number", most);
    marks.add("participant_values", participants);
    std::string means; // words: panel, mean and its interval, if there is one
    for (std::size_t i = 0; i < results.conditions.size(); ++i) {
        const study::ConditionSummary &group = results.conditions[i];
        const bool has_interval = group.on_scale.participants > 1;
        means += fmt::format("{} {:.17g} {:.17g} {:.17g} ", i + 1, group.mean,
                             has_interval ? group.low : group.mean,
                             has_interval ? group.high : group.mean);
    }
    marks.add("mean_values", means);
    for (std::size_t i = 0; i < results.conditions.size(); ++i) {
        const std::size_t condition = results.conditions[i].condition;
        marks.add(fmt::format("title_{}", i + 1), protocol.conditions[condition].name);
    }
    marks.add("panels", static_cast<double>(results.conditions.size()));
    return chart_of("study_group.gnuplot", marks, folder, "thresholds.csv", "group.svg");
}

} // namespace

Chart plan_picture(const study::Protocol &protocol, const PrecisionPlan &plan,
                   const std::filesystem::path &folder) {
    const study::Scale scale = plan.question.analysis.family.scale;
    const bool are_ratios = scale == study::Scale::logarithmic;
    ChartMarks marks;
    marks.add("heading", "Precision by trials: " + protocol.title);
    marks.add("note", fmt::format("{} simulated studies of {}; {}", plan.question.studies,
                                  observer_text(plan.observer),
                                  study::kMethodNames[protocol.method.index()]));
    marks.add("is_logarithmic", are_ratios ? 1.0 : 0.0);
    marks.add("width_label",
              are_ratios ? "95 % interval of a threshold, highest/lowest"
                         : "95 % interval of a threshold, width in " + level_label(protocol));
    marks.add("usual_trials", plan.usual_trials);
    marks.add("wanted", plan.wanted ? shown_width(scale, *plan.wanted) : 0.0);
    const std::optional<double> trials =
        plan.wanted ? study::trials_for_width(plan.rows, *plan.wanted) : std::nullopt;
    marks.add("wanted_trials", trials ? std::ceil(*trials) : 0.0);
    return chart_of("study_precision.gnuplot", marks, folder, "precision.csv", "precision.svg");
}

std::vector<Chart> results_pictures(const study::Protocol &protocol,
                                    const study::StudyResults &results,
                                    const std::filesystem::path &folder) {
    std::vector<Chart> pictures;
    const std::vector<SeriesRows> rows = rows_of(results);
    const bool has_functions = !std::holds_alternative<study::Adjustment>(protocol.method);
    const bool has_traces = !std::holds_alternative<study::ConstantStimuli>(protocol.method);
    for (auto first = rows.begin(); first != rows.end();) {
        const std::string &participant = first->result->series.participant;
        const auto last = std::find_if(first, rows.end(), [&participant](const SeriesRows &one) {
            return one.result->series.participant != participant;
        });
        const std::vector<SeriesRows> series(first, last);
        const bool is_fitted = std::ranges::any_of(
            series, [](const SeriesRows &one) { return one.result->fitted.has_value(); });
        if (has_functions && is_fitted) {
            pictures.push_back(functions_picture(protocol, results, folder, participant, series));
        }
        if (has_traces) {
            pictures.push_back(traces_picture(protocol, results, folder, participant, series));
        }
        first = last;
    }
    if (!results.conditions.empty()) {
        pictures.push_back(group_picture(protocol, results, folder));
    }
    return pictures;
}

} // namespace springdrive::app
