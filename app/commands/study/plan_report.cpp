#include "app/commands/study/plan_report.h"

#include "base/print.h"
#include "engine/study/protocol/session_plan.h"

#include <cmath>

namespace springdrive::app {

namespace {

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

void write_wanted(std::ostream &out, const study::Protocol &protocol, const PrecisionPlan &plan) {
    if (!plan.wanted) {
        return;
    }
    const std::string width =
        fmt::format("{} {:.3g}", are_ratios(plan) ? "a factor of" : "a width of",
                    shown_width(plan.question.analysis.family.scale, *plan.wanted));
    const std::optional<double> trials = study::trials_for_width(plan.rows, *plan.wanted);
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

} // namespace

double shown_width(study::Scale scale, double width) {
    return scale == study::Scale::logarithmic ? std::exp(width) : width;
}

std::string observer_text(const study::PsychometricFunction &observer) {
    return fmt::format("observers with threshold {:.4g}, slope {:.4g}, lapse rate {:.3g}",
                       observer.threshold, observer.slope, observer.lapse);
}

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
    write_wanted(out, protocol, plan);
}

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

} // namespace springdrive::app
