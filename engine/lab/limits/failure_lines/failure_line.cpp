#include "engine/lab/limits/failure_lines/failure_line.h"

#include "base/bisection.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace springdrive::limits {

namespace {

double last_whole(const TriedLine &tried) {
    return bisect(
               {tried.holds_at, tried.fails_at},
               [](const Bracket &now) { return now.width() > 1.0; }, tried.holds,
               [](const Bracket &now) { return std::trunc(now.middle()); })
        .holds_at;
}

double last_value(const TriedLine &tried, double fails_at) {
    return last_that_holds({tried.holds_at, fails_at}, tried.resolution, tried.holds);
}

/// The first value that fails, from `holds_at` on; nothing where none does.
std::optional<double> first_failure(const TriedLine &tried) {
    constexpr int kValues = 12;
    const double ratio = tried.fails_at / tried.holds_at;
    for (int i = 0; i <= kValues; ++i) {
        const double share = static_cast<double>(i) / kValues;
        const double value = ratio > 0.0 ? tried.holds_at * std::pow(ratio, share)
                                         : std::lerp(tried.holds_at, tried.fails_at, share);
        if (!tried.holds(value)) {
            return value;
        }
    }
    return std::nullopt;
}

std::optional<double> measurement(const TriedLine &tried) {
    if (tried.reading) {
        return tried.reading();
    }
    if (tried.holds(tried.fails_at)) {
        const std::optional<double> fails_at = first_failure(tried);
        return fails_at ? std::optional(last_value(tried, *fails_at)) : std::nullopt;
    }
    return tried.whole ? last_whole(tried) : last_value(tried, tried.fails_at);
}

} // namespace

FailureLine measured(const TriedLine &tried) {
    FailureLine line = tried.line;
    line.measured = measurement(tried);
    return line;
}

std::string with_unit(double value, const char *unit) {
    return fmt::format("{:g} {}", value, unit);
}

} // namespace springdrive::limits
