#include "engine/lab/limits/method_limits/method_limits.h"

#include "engine/lab/limits/method_limits/limit_trials.h"
#include "engine/lab/limits/method_limits/loop_limits.h"

#include <fmt/core.h>

#include <array>
#include <cstdint>
#include <iterator>

namespace springdrive::limits {

namespace {

/// The groups of rows, with the limits of sampled loops between them.
enum class Kind : std::uint8_t {
    cancellation,
    inverse,
    direction,
    integrators,
    contact,
    servo,
    motor
};
constexpr std::array kKinds{Kind::cancellation, Kind::inverse, Kind::direction, Kind::integrators,
                            Kind::contact,      Kind::servo,   Kind::motor};

void append(std::vector<LimitTrial> &lines, std::vector<LimitTrial> more) {
    lines.insert(lines.end(), std::make_move_iterator(more.begin()),
                 std::make_move_iterator(more.end()));
}

std::vector<LimitTrial> limit_trials(const loops::StabilityCase &which, Kind kind) {
    std::vector<LimitTrial> lines;
    switch (kind) {
    case Kind::cancellation:
        return cancellation_trials(which.device);
    case Kind::inverse:
        return inverse_trials(which.device);
    case Kind::direction:
        return {direction_trial(which)};
    case Kind::integrators:
        return integrator_trials(which);
    case Kind::contact:
        lines = closest_point_trials();
        append(lines, proxy_trials());
        return lines;
    case Kind::servo:
        lines = servo_trials(which);
        append(lines, release_trials(which));
        return lines;
    case Kind::motor:
        lines = amplifier_trials(which.device);
        append(lines, limiter_trials(which));
        append(lines, heat_trials(which.device));
        return lines;
    }
    return lines;
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

std::vector<LimitTrial> limit_trials(const loops::StabilityCase &which) {
    std::vector<LimitTrial> lines;
    for (const Kind kind : kKinds) {
        append(lines, limit_trials(common(which), kind));
    }
    return lines;
}

std::vector<MethodLimit> method_limits(const loops::StabilityCase &asked,
                                       const std::function<void(double)> &progress) {
    const loops::StabilityCase which = common(asked);
    constexpr double kSteps = kDriftSteps + 2.0 + kKinds.size();
    double done = 0.0;
    const auto step = [&] { progress(++done / kSteps); };
    std::vector<MethodLimit> lines;
    const auto add = [&](const std::vector<MethodLimit> &more) {
        lines.insert(lines.end(), more.begin(), more.end());
    };
    const auto add_trials = [&](Kind kind) {
        for (const LimitTrial &trial : limit_trials(which, kind)) {
            lines.push_back(measured(trial));
        }
        step();
    };
    add_trials(Kind::cancellation);
    add(drift_limits(which, step));
    add_trials(Kind::inverse);
    add(alpha_limits(which));
    step();
    add_trials(Kind::direction);
    add(wall_limits(which));
    step();
    add_trials(Kind::integrators);
    add_trials(Kind::contact);
    add_trials(Kind::servo);
    add_trials(Kind::motor);
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
