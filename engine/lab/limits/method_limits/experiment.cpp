#include "engine/lab/limits/method_limits/experiment.h"

#include "base/bisection.h"
#include "engine/lab/limits/method_limits/experiment_list.h"
#include "engine/lab/limits/stability_limits.h"

#include <cmath>
#include <iterator>

namespace springdrive::limits {

namespace {

double last_whole(const Experiment &experiment) {
    return bisect(
               {experiment.tried.holds_at, experiment.tried.fails_at},
               [](const Bracket &now) { return now.width() > 1.0; }, experiment.holds,
               [](const Bracket &now) { return std::trunc(now.middle()); })
        .holds_at;
}

double last_value(const Experiment &experiment, double fails_at) {
    const TriedValues &tried = experiment.tried;
    return last_that_holds({tried.holds_at, fails_at}, tried.resolution, experiment.holds);
}

/// The first value that fails, from `holds_at` on; nothing where none does.
std::optional<double> first_failure(const Experiment &experiment) {
    constexpr int kValues = 12;
    const TriedValues &tried = experiment.tried;
    const double ratio = tried.fails_at / tried.holds_at;
    for (int i = 0; i <= kValues; ++i) {
        const double share = static_cast<double>(i) / kValues;
        const double value = ratio > 0.0 ? tried.holds_at * std::pow(ratio, share)
                                         : std::lerp(tried.holds_at, tried.fails_at, share);
        if (!experiment.holds(value)) {
            return value;
        }
    }
    return std::nullopt;
}

std::optional<double> searched(const Experiment &experiment) {
    if (experiment.reading) {
        return experiment.reading();
    }
    if (!experiment.holds(experiment.tried.fails_at)) {
        return experiment.tried.whole ? last_whole(experiment)
                                      : last_value(experiment, experiment.tried.fails_at);
    }
    const std::optional<double> fails_at = first_failure(experiment);
    return fails_at ? std::optional(last_value(experiment, *fails_at)) : std::nullopt;
}

std::vector<MethodLimit> limits_of_loop(const MethodLimit &row, const LoopSweep &loop) {
    std::vector<MethodLimit> rows;
    const loops::StabilityParameter &parameter = *loop.parameter;
    for (const StabilityLimit &limit :
         stability_limits(loop.which, parameter, {parameter.from, parameter.to})) {
        rows.push_back({row.method,
                        std::string(parameter.symbol) + (limit.stable_below ? " above" : " below"),
                        std::string(parameter.unit), row.setting, limit.predicted,
                        limit.simulated_linear, limit.simulated_all});
    }
    return rows;
}

/// The settings that all rows share; each row sets the rest.
loops::StabilityCase common(const loops::StabilityCase &which) {
    loops::StabilityCase plain;
    plain.device = which.device;
    plain.q_rad = which.q_rad;
    plain.hands = which.hands;
    return plain;
}

} // namespace

std::vector<Experiment> experiments(const loops::StabilityCase &requested) {
    const loops::StabilityCase which = common(requested);
    Experiments all;
    for (Experiments group :
         {cancellation_experiments(which.device), drift_experiments(which),
          inverse_experiments(which.device), alpha_experiments(which), direction_experiments(which),
          wall_experiments(which), integrator_experiments(which), contact_experiments(),
          servo_experiments(which), amplifier_experiments(which.device), limiter_experiments(which),
          heat_experiments(which.device)}) {
        all.insert(all.end(), std::make_move_iterator(group.begin()),
                   std::make_move_iterator(group.end()));
    }
    return all;
}

std::vector<MethodLimit> measured(const Experiment &experiment) {
    if (experiment.loop) {
        return limits_of_loop(experiment.row, *experiment.loop);
    }
    MethodLimit row = experiment.row;
    row.measured = searched(experiment);
    return {row};
}

std::vector<MethodLimit> method_limits(const loops::StabilityCase &which,
                                       const std::function<void(double)> &progress) {
    const std::vector<Experiment> all = experiments(which);
    std::vector<MethodLimit> lines;
    double done = 0.0;
    for (const Experiment &experiment : all) {
        const std::vector<MethodLimit> rows = measured(experiment);
        lines.insert(lines.end(), rows.begin(), rows.end());
        progress(++done / static_cast<double>(all.size()));
    }
    return lines;
}

Table method_limits_document(const std::vector<MethodLimit> &lines) {
    Table table =
        Table::with_columns("method,fails,setting,predicted:.4g,measured:.4g,as it is:.4g");
    for (const MethodLimit &line : lines) {
        table.rows.push_back({line.method, fmt::format("{} ({})", line.fails, line.unit),
                              line.setting, line.predicted, line.measured, line.measured_as_it_is});
    }
    return table;
}

Table method_limits_table(const std::vector<MethodLimit> &lines) {
    Table table =
        Table::with_columns("method,fails,unit,setting,predicted,measured,measured_as_it_is");
    for (const MethodLimit &line : lines) {
        table.rows.push_back({line.method, line.fails, line.unit, line.setting, line.predicted,
                              line.measured, line.measured_as_it_is});
    }
    return table;
}

} // namespace springdrive::limits
