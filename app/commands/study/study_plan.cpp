#include "app/commands/study/study_commands.h"

#include "app/commands/common_options.h"
#include "app/commands/output_files.h"
#include "app/commands/study/observer_options.h"
#include "app/commands/study/opened_study.h"
#include "app/commands/study/plan_report.h"
#include "app/commands/study/study_pictures.h"
#include "base/input_error.h"
#include "engine/study/methods/task.h"
#include "engine/study/protocol/session_plan.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <type_traits>
#include <variant>

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
double wanted_width(double typed, study::Scale scale) {
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

void plan_typed(const TypedPlan &typed) {
    const study::Protocol protocol = typed_protocol(typed.protocol);
    PrecisionPlan plan;
    plan.observer = observer_of(typed.truth, protocol);
    plan.question = study::precision_question(protocol, plan.observer);
    plan.question.studies = typed.studies;
    plan.question.trials = possible_trials(protocol.method, typed.trials);
    if (typed.precision) {
        plan.wanted = wanted_width(*typed.precision, plan.question.analysis.family.scale);
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
