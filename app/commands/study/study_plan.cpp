#include "app/commands/command.h"
#include "app/commands/common_options.h"
#include "app/commands/output_files.h"
#include "app/commands/study/observer_options.h"
#include "app/commands/study/opened_study.h"
#include "app/figures/gnuplot.h"
#include "base/input_error.h"
#include "base/print.h"
#include "base/table.h"
#include "engine/study/analysis/precision_plan.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/methods/psychometric_function.h"
#include "engine/study/protocol/session_plan.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

namespace springdrive::app {

namespace {

struct TypedPlan {
    std::filesystem::path protocol;
    std::optional<double> precision;
    std::vector<int> trials{10, 15, 20, 30, 40, 60, 80, 120, 160, 240};
    int studies = 200;
    TypedObserver truth;
    std::filesystem::path out; ///< empty: the table only
    Existing existing = Existing::keep;
};

/// Trials come in multiples of it: a block of constant stimuli, one of each track.
int multiple_of(const study::Method &method) {
    return std::visit(
        [](const auto &one) {
            using Kind = std::decay_t<decltype(one)>;
            if constexpr (std::is_same_v<Kind, study::ConstantStimuli>) {
                return static_cast<int>(one.levels.size()) * one.repetitions;
            } else if constexpr (std::is_same_v<Kind, study::Staircases>) {
                return static_cast<int>(one.start_levels.size());
            } else {
                return 1;
            }
        },
        method);
}

/// Rising, each once, rounded up to what the method can present.
std::vector<int> possible_trials(const study::Method &method, std::vector<int> trials) {
    const int multiple = multiple_of(method);
    for (int &each : trials) {
        each = (each + multiple - 1) / multiple * multiple;
    }
    std::ranges::sort(trials);
    trials.erase(std::unique(trials.begin(), trials.end()), trials.end());
    return trials;
}

/// On the scale.
double requested_width(double typed, study::Scale scale) {
    const bool are_ratios = scale == study::Scale::logarithmic;
    constexpr double kMinFactor = 1.01; // far below what any participant's patience gives
    constexpr double kMaxFactor = 1000.0;
    const double least = are_ratios ? kMinFactor : study::kMinRatioTyped;
    const double most = are_ratios ? kMaxFactor : study::kMaxTyped;
    if (!(typed >= least && typed <= most)) { // a NaN too
        throw InputError(fmt::format(
            "--precision is {:g}; it must be from {:g} to {:g}: {}", typed, least, most,
            are_ratios ? "a factor from end to end of the interval, as the levels' scale is "
                         "logarithmic"
                       : "a width in the level's unit"));
    }
    return are_ratios ? std::log(typed) : typed;
}

struct PrecisionPlan {
    study::PsychometricFunction observer; ///< all simulated ones are alike
    study::PrecisionQuestion question;
    std::vector<study::Precision> rows;
    std::optional<double> requested; ///< width, on the scale
    int usual_trials = 0;            ///< that the protocol takes of such an observer
};

/// A width on the scale, as it is shown: a factor from end to end on a logarithmic one, else in the
/// level's unit.
double shown_width(study::Scale scale, double width) {
    return scale == study::Scale::logarithmic ? std::exp(width) : width;
}

double minutes_of(const study::Protocol &protocol, double trials) {
    return trials * study::usual_trial_s(protocol) / 60.0;
}

bool are_ratios(const PrecisionPlan &plan) {
    return plan.question.analysis.family.scale == study::Scale::logarithmic;
}

/// An error on the scale as it is shown: in percent of the threshold, or in the level's unit.
double shown_error(const PrecisionPlan &plan, double error) {
    return are_ratios(plan) ? 100.0 * std::expm1(error) : error;
}

void write_requested(std::ostream &out, const study::Protocol &protocol,
                     const PrecisionPlan &plan) {
    if (!plan.requested) {
        return;
    }
    const std::string width =
        fmt::format("{} {:.3g}", are_ratios(plan) ? "a factor of" : "a width of",
                    shown_width(plan.question.analysis.family.scale, *plan.requested));
    const std::optional<double> trials = study::trials_for_width(plan.rows, *plan.requested);
    if (!trials) {
        print(out,
              "{} takes more than {} trials of a participant in a condition; --trials tries more\n",
              width, plan.rows.back().trials);
        return;
    }
    const bool is_first = *trials <= plan.rows.front().trials;
    print(out,
          "{} takes {}{:.0f} trials of a participant in a condition, {:.0f} min without breaks\n",
          width, is_first ? "at most " : "", std::ceil(*trials),
          std::ceil(minutes_of(protocol, *trials)));
}

/// "observers with threshold 25, slope 2, lapse rate 0.02", for people.
std::string observer_text(const study::PsychometricFunction &observer) {
    return fmt::format("observers with threshold {:.4g}, slope {:.4g}, lapse rate {:.3g}",
                       observer.threshold, observer.slope, observer.lapse);
}

/// A table, and what the wanted precision takes.
void write_plan(std::ostream &out, const study::Protocol &protocol, const PrecisionPlan &plan) {
    const study::Scale scale = plan.question.analysis.family.scale;
    print(out, "{}\n{} simulated studies of {}\n\n", protocol.title, plan.question.studies,
          observer_text(plan.observer));
    Table table = Table::with_columns(
        are_ratios(plan)
            ? "trials,min:.1f,95 % factor\nmedian:.3g,95 % factor\n4 of 5:.3g,bias\n%:.2g,"
              "rms error\n%:.2g,interval\nholds it"
            : "trials,min:.1f,95 % width\nmedian:.3g,95 % width\n4 of 5:.3g,bias\nlevel's unit:.2g,"
              "rms error\nlevel's unit:.2g,interval\nholds it");
    for (const study::Precision &row : plan.rows) {
        table.rows.push_back({row.trials, minutes_of(protocol, row.trials),
                              shown_width(scale, row.median_width),
                              shown_width(scale, row.width_of_most), shown_error(plan, row.bias),
                              shown_error(plan, row.rms_error),
                              Cell::like_number(fmt::format("{:.0f} %", 100.0 * row.coverage))});
    }
    write_text(out, table);
    print(out, "\nthe protocol takes {} trials of a participant in a condition\n",
          plan.usual_trials);
    write_requested(out, protocol, plan);
}

/// For programs: a row a number of trials; widths and errors on the scale.
Table plan_table(const study::Protocol &protocol, const PrecisionPlan &plan) {
    Table table = Table::with_columns(
        "trials,minutes,median_width,width_of_most,bias,rms_error,coverage,scale");
    for (const study::Precision &row : plan.rows) {
        table.rows.push_back({row.trials, minutes_of(protocol, row.trials), row.median_width,
                              row.width_of_most, row.bias, row.rms_error, row.coverage,
                              are_ratios(plan) ? "logarithmic" : "linear"});
    }
    return table;
}

/// The widths of the 95 % interval over the trials: precision.svg, from precision.csv.
Chart plan_picture(const study::Protocol &protocol, const PrecisionPlan &plan,
                   const std::filesystem::path &folder) {
    const study::Scale scale = plan.question.analysis.family.scale;
    ChartMarks marks;
    marks.add("heading", "Precision by trials: " + protocol.title);
    marks.add("note", fmt::format("{} simulated studies of {}; {}", plan.question.studies,
                                  observer_text(plan.observer),
                                  study::kMethodNames[protocol.method.index()]));
    marks.add("is_logarithmic", are_ratios(plan) ? 1.0 : 0.0);
    marks.add("width_label", are_ratios(plan) ? "95 % interval of a threshold, highest/lowest"
                                              : "95 % interval of a threshold, width in " +
                                                    study::level_label(protocol));
    marks.add("usual_trials", plan.usual_trials);
    marks.add("wanted", plan.requested ? shown_width(scale, *plan.requested) : 0.0);
    const std::optional<double> trials =
        plan.requested ? study::trials_for_width(plan.rows, *plan.requested) : std::nullopt;
    marks.add("wanted_trials", trials ? std::ceil(*trials) : 0.0);
    return chart_of("study_precision", marks, folder, "precision.csv", "precision.svg");
}

void plan_typed(const TypedPlan &typed) {
    const study::Protocol protocol = typed_protocol(typed.protocol);
    PrecisionPlan plan;
    plan.observer = observer_of(typed.truth, protocol);
    plan.question = study::precision_question(protocol, plan.observer);
    plan.question.studies = typed.studies;
    plan.question.trials = possible_trials(protocol.method, typed.trials);
    if (typed.precision) {
        plan.requested = requested_width(*typed.precision, plan.question.analysis.family.scale);
    }
    if (const std::string wrong = study::validate(plan.question, protocol.task); !wrong.empty()) {
        throw InputError("study plan: " + wrong);
    }
    if (!typed.out.empty()) {
        make_output_folder(typed.out);
        RunFiles files{{typed.protocol}, {}, {}};
        add_chart_files(files, typed.out, "precision");
        check_outputs(files, typed.existing);
    }
    plan.usual_trials = study::usual_trials(protocol, plan.observer);
    plan.rows = study::precision_by_trials(plan.question);
    write_plan(std::cout, protocol, plan);
    if (!typed.out.empty()) {
        write_output((typed.out / "precision.csv").string(),
                     [&](std::ostream &out) { write_csv(out, plan_table(protocol, plan)); },
                     typed.existing);
        draw(plan_picture(protocol, plan, typed.out), typed.existing);
        std::cerr << "written: " << (typed.out / "precision.svg").string() << '\n';
    }
}

} // namespace

void add_study_plan_command(Command &study) {
    Command command = study.add_subcommand(
        "plan", "how many trials a precision takes, by studies with simulated observers");
    const auto typed = std::make_shared<TypedPlan>();
    command.add_option("protocol", typed->protocol, "a protocol file").type_name("FILE").required();
    command
        .add_option("--precision", typed->precision,
                    "wanted of a participant's threshold in a condition: its 95 % interval from "
                    "end to end, in four of five studies; a factor, such as 1.5, where the levels' "
                    "scale is logarithmic, else in the level's unit")
        .type_name("WIDTH");
    command
        .add_option("--trials", typed->trials,
                    "which numbers are tried, separated by commas; rounded up to whole blocks "
                    "[10,15,20,30,40,60,80,120,160,240]")
        .type_name("N,...")
        .delimiter(',');
    command
        .add_option("--studies", typed->studies,
                    "simulated for each [" + std::to_string(typed->studies) + "]")
        .type_name("N");
    add_observer_options(command, typed->truth);
    command
        .add_option("--out", typed->out,
                    "folder for the table as CSV and the picture as SVG; created if missing")
        .type_name("DIR");
    add_force_option(command, typed->existing);
    command.callback([typed] { plan_typed(*typed); });
}

} // namespace springdrive::app
