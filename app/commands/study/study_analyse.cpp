#include "app/commands/command.h"
#include "app/commands/output_files.h"
#include "app/commands/study/opened_study.h"
#include "app/figures/gnuplot.h"
#include "base/print.h"
#include "base/table.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/results/study_results.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <iostream>
#include <memory>
#include <ostream>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace springdrive::app {

namespace {

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
    marks.add("level_label", study::level_label(protocol));
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
    return chart_of("study_functions", marks, folder, "functions.csv",
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
    return chart_of("study_traces", marks, folder, "traces.csv", "traces_" + participant + ".svg");
}

/// The interval of two participants may reach from 0 to infinity: as far as is drawn.
constexpr double kMaxDrawn = 1e99;

Chart group_picture(const study::Protocol &protocol, const study::StudyResults &results,
                    const std::filesystem::path &folder) {
    const bool is_adjustment = std::holds_alternative<study::Adjustment>(protocol.method);
    ChartMarks marks;
    add_common(marks, protocol, results,
               {protocol.title, "bars: 95 % intervals; mean of random effects"});
    marks.add("estimate_label", is_adjustment ? "mean setting: " : "threshold: ");
    int most = 1;
    double lowest = kMaxDrawn; // on the axis
    double highest = 0.0;
    const auto drawn = [&](double level) {
        if (results.family.scale == study::Scale::logarithmic) {
            level = std::clamp(level, 1.0 / kMaxDrawn, kMaxDrawn);
        }
        lowest = std::min(lowest, level);
        highest = std::max(highest, level);
        return level;
    };
    std::vector<std::vector<double>> participants; // panel, number, estimate and its interval
    for (const study::SeriesResult &result : results.series) {
        most = std::max(most, result.series.number);
        const auto panel = std::ranges::find(results.conditions, result.series.condition,
                                             &study::ConditionSummary::condition) -
                           results.conditions.begin() + 1;
        const auto append = [&](double estimate, double low, double high) {
            participants.push_back({static_cast<double>(panel),
                                    static_cast<double>(result.series.number), drawn(estimate),
                                    drawn(low), drawn(high)});
        };
        if (result.settings) {
            append(result.settings->mean, result.settings->low, result.settings->high);
        } else if (result.fitted) {
            const auto &threshold = result.fitted->threshold;
            append(threshold.median, threshold.low, threshold.high);
        }
    }
    marks.add("highest_number", most);
    marks.add("participants", participants);
    std::vector<std::vector<double>> means; // panel, mean and its interval, if there is one
    for (std::size_t i = 0; i < results.conditions.size(); ++i) {
        const study::ConditionSummary &group = results.conditions[i];
        const bool has_interval = group.on_scale.participants > 1;
        means.push_back({static_cast<double>(i + 1), drawn(group.mean),
                         drawn(has_interval ? group.low : group.mean),
                         drawn(has_interval ? group.high : group.mean)});
        marks.add(fmt::format("title_{}", i + 1), protocol.conditions[group.condition].name);
    }
    marks.add("means", means);
    marks.add("lowest", lowest);
    marks.add("highest", highest);
    marks.add("panels", static_cast<double>(results.conditions.size()));
    return chart_of("study_group", marks, folder, "", "group.svg");
}

/// Of each participant the fitted functions and the traces of the method, functions_P01.svg and
/// traces_P01.svg, and the group, group.svg; from the tables of `study::kResultsTables`. Constant
/// stimuli have no traces worth drawing, adjustments no functions.
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

/// A line for each participant and condition, then one for each condition.
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

struct TypedAnalysis {
    std::filesystem::path study;
    std::filesystem::path out; ///< empty: the table only
    study::DeviceKind device = study::DeviceKind::usb;
    Existing existing = Existing::keep;
};

RunFiles tables_of(const TypedAnalysis &typed) {
    RunFiles files{files_of_study(typed.study), {}, {}};
    for (const study::ResultsTable &table : study::kResultsTables) {
        files.written.push_back(typed.out / table.file);
    }
    return files;
}

/// What `write_files` will draw, if all of it can be written.
std::vector<Chart> checked_pictures(const TypedAnalysis &typed, const study::Protocol &protocol,
                                    const study::StudyResults &results) {
    std::vector<Chart> pictures = results_pictures(protocol, results, typed.out);
    RunFiles files = tables_of(typed);
    for (const Chart &picture : pictures) {
        files.written.push_back(typed.out / picture.svg);
    }
    check_outputs(files, typed.existing);
    return pictures;
}

/// The pictures are the last: all numbers are there even if nothing can be drawn.
void write_files(const TypedAnalysis &typed, const study::Protocol &protocol,
                 const study::StudyResults &results, const std::vector<Chart> &pictures) {
    for (const study::ResultsTable &table : study::kResultsTables) {
        write_output((typed.out / table.file).string(),
                     [&](std::ostream &out) { table.write(out, table.make(protocol, results)); },
                     {typed.existing, Readers::owner});
    }
    ProgressLine line;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        line.show("pictures", static_cast<double>(i) / static_cast<double>(pictures.size()));
        draw(pictures[i], {typed.existing, Readers::owner});
    }
}

void analyse(const TypedAnalysis &typed) {
    const OpenedStudy opened = read_opened_study(typed.study);
    refuse_without_trials(opened.contents, typed.device, typed.study);
    if (!typed.out.empty()) {
        make_output_folder(typed.out);
        check_outputs(tables_of(typed), typed.existing); // before the fits, which take long
    }
    study::StudyResults results;
    {
        ProgressLine line;
        results = study::results_of(opened.protocol, opened.contents, typed.device,
                                    [&line](double share) { line.show("fits", share); });
    }
    std::vector<Chart> pictures;
    if (!typed.out.empty()) {
        pictures = checked_pictures(typed, opened.protocol, results);
    }
    write_results(std::cout, opened.protocol, results);
    if (!typed.out.empty()) {
        write_files(typed, opened.protocol, results, pictures);
        std::cerr << "written: tables and pictures in " << typed.out.string() << '\n';
    }
    if (const std::string text = left_out_text(opened.contents, typed.device, typed.study);
        !text.empty()) {
        std::cerr << text << '\n';
    }
}

} // namespace

void add_study_analyse_command(Command &study) {
    Command command = study.add_subcommand(
        "analyse", "thresholds, slopes, fits and groups, with pictures; also while a study runs");
    const auto typed = std::make_shared<TypedAnalysis>();
    add_study_file_argument(command, typed->study);
    command
        .add_option("--out", typed->out,
                    "folder for all tables as CSV and pictures as SVG; created if missing")
        .type_name("DIR");
    add_device_kind_option(command, typed->device);
    add_force_option(command, typed->existing);
    command.callback([typed] { analyse(*typed); });
}

} // namespace springdrive::app
