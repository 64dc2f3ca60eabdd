#include "engine/lab/limits/method_limits/method_limit.h"

#include "base/bisection.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace springdrive::limits {

namespace {

double last_whole(const LimitTrial &trial) {
    return bisect(
               {trial.holds_at, trial.fails_at},
               [](const Bracket &now) { return now.width() > 1.0; }, trial.holds,
               [](const Bracket &now) { return std::trunc(now.middle()); })
        .holds_at;
}

double last_value(const LimitTrial &trial, double fails_at) {
    return last_that_holds({trial.holds_at, fails_at}, trial.resolution, trial.holds);
}

/// The first value that fails, from `holds_at` on; nothing where none does.
std::optional<double> first_failure(const LimitTrial &trial) {
    constexpr int kValues = 12;
    const double ratio = trial.fails_at / trial.holds_at;
    for (int i = 0; i <= kValues; ++i) {
        const double share = static_cast<double>(i) / kValues;
        const double value = ratio > 0.0 ? trial.holds_at * std::pow(ratio, share)
                                         : std::lerp(trial.holds_at, trial.fails_at, share);
        if (!trial.holds(value)) {
            return value;
        }
    }
    return std::nullopt;
}

std::optional<double> measurement(const LimitTrial &trial) {
    if (trial.reading) {
        return trial.reading();
    }
    if (trial.holds(trial.fails_at)) {
        const std::optional<double> fails_at = first_failure(trial);
        return fails_at ? std::optional(last_value(trial, *fails_at)) : std::nullopt;
    }
    return trial.whole ? last_whole(trial) : last_value(trial, trial.fails_at);
}

} // namespace

MethodLimit measured(const LimitTrial &trial) {
    MethodLimit line = trial.line;
    line.measured = measurement(trial);
    return line;
}

std::string with_unit(double value, const char *unit) {
    return fmt::format("{:g} {}", value, unit);
}

} // namespace springdrive::limits
