#include "engine/lab/limits/failure_lines/failure_lines.h"

#include "base/print.h"
#include "engine/lab/limits/failure_lines/cancellation_lines.h"
#include "engine/lab/limits/failure_lines/closest_point_lines.h"
#include "engine/lab/limits/failure_lines/direction_line.h"
#include "engine/lab/limits/failure_lines/integrator_lines.h"
#include "engine/lab/limits/failure_lines/kinematics_lines.h"
#include "engine/lab/limits/failure_lines/letting_go_lines.h"
#include "engine/lab/limits/failure_lines/loop_lines.h"
#include "engine/lab/limits/failure_lines/motor_lines.h"
#include "engine/lab/limits/failure_lines/proxy_lines.h"
#include "engine/lab/limits/failure_lines/servo_lines.h"

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <ostream>

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

void append(std::vector<TriedLine> &lines, std::vector<TriedLine> more) {
    lines.insert(lines.end(), std::make_move_iterator(more.begin()),
                 std::make_move_iterator(more.end()));
}

std::vector<TriedLine> tried_lines(const loops::StabilityCase &which, Kind kind) {
    std::vector<TriedLine> lines;
    switch (kind) {
    case Kind::cancellation:
        return cancellation_lines(which.device);
    case Kind::inverse:
        return inverse_lines(which.device);
    case Kind::direction:
        return {direction_line(which)};
    case Kind::integrators:
        return integrator_lines(which);
    case Kind::contact:
        lines = closest_point_lines();
        append(lines, proxy_lines());
        return lines;
    case Kind::servo:
        lines = servo_lines(which);
        append(lines, letting_go_lines(which));
        return lines;
    case Kind::motor:
        lines = amplifier_lines(which.device);
        append(lines, held_back_lines(which));
        append(lines, heat_lines(which.device));
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

std::string number(const std::optional<double> &value) {
    return value ? fmt::format("{:.4g}", *value) : "–";
}

} // namespace

std::vector<TriedLine> tried_lines(const loops::StabilityCase &which) {
    std::vector<TriedLine> lines;
    for (const Kind kind : kKinds) {
        append(lines, tried_lines(common(which), kind));
    }
    return lines;
}

std::vector<FailureLine> failure_lines(const loops::StabilityCase &asked,
                                       const std::function<void(double)> &progress) {
    const loops::StabilityCase which = common(asked);
    constexpr double kSteps = kDriftSteps + 2.0 + kKinds.size();
    double done = 0.0;
    const auto step = [&] { progress(++done / kSteps); };
    std::vector<FailureLine> lines;
    const auto add = [&](const std::vector<FailureLine> &more) {
        lines.insert(lines.end(), more.begin(), more.end());
    };
    const auto add_tried = [&](Kind kind) {
        for (const TriedLine &tried : tried_lines(which, kind)) {
            lines.push_back(measured(tried));
        }
        step();
    };
    add_tried(Kind::cancellation);
    add(drift_lines(which, step));
    add_tried(Kind::inverse);
    add(alpha_lines(which));
    step();
    add_tried(Kind::direction);
    add(wall_lines(which));
    step();
    add_tried(Kind::integrators);
    add_tried(Kind::contact);
    add_tried(Kind::servo);
    add_tried(Kind::motor);
    return lines;
}

void write_failure_lines(std::ostream &out, const std::vector<FailureLine> &lines) {
    out << "| method | fails | setting | predicted | measured | as it is |\n"
           "| --- | --- | --- | ---: | ---: | ---: |\n";
    for (const FailureLine &line : lines) {
        print(out, "| {} | {} ({}) | {} | {} | {} | {} |\n", line.method, line.fails, line.unit,
              line.setting, number(line.predicted), number(line.measured),
              number(line.measured_as_it_is));
    }
}

void write_failure_lines_csv(std::ostream &out, const std::vector<FailureLine> &lines) {
    out << "method,fails,unit,setting,predicted,measured,measured_as_it_is\n";
    for (const FailureLine &line : lines) {
        print(out, "{},{},{},{},{},{},{}\n", csv_cell(line.method), csv_cell(line.fails),
              csv_cell(line.unit), csv_cell(line.setting), csv_cell(line.predicted.value_or(NAN)),
              csv_cell(line.measured.value_or(NAN)),
              csv_cell(line.measured_as_it_is.value_or(NAN)));
    }
}

} // namespace springdrive::limits
