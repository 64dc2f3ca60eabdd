#include "app/commands/study/study_commands.h"

#include "app/commands/output_files.h"
#include "app/commands/progress_line.h"
#include "app/commands/study/opened_study.h"
#include "app/commands/study/study_pictures.h"
#include "base/print.h"
#include "base/table.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/results/study_results.h"

#include <cmath>
#include <iostream>
#include <memory>
#include <ostream>
#include <string>
#include <variant>
#include <vector>

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
                     [&](std::ostream &out) { write_csv(out, table.make(protocol, results)); },
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
