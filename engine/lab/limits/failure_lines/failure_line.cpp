#include "engine/lab/limits/failure_lines/failure_line.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace springdrive::limits {

namespace {

double last_whole(const TriedLine &tried) {
    double holds_at = tried.holds_at;
    double fails_at = tried.fails_at;
    while (std::abs(fails_at - holds_at) > 1.0) {
        const double middle = std::trunc(0.5 * (holds_at + fails_at));
        (tried.holds(middle) ? holds_at : fails_at) = middle;
    }
    return holds_at;
}

/// The first value that fails, from where it should hold on; nothing where none does.
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
        return fails_at ? std::optional(turning_point(tried.holds_at, *fails_at, tried.holds,
                                                      tried.resolution))
                        : std::nullopt;
    }
    return tried.whole
               ? last_whole(tried)
               : turning_point(tried.holds_at, tried.fails_at, tried.holds, tried.resolution);
}

} // namespace

double turning_point(double holds_at, double fails_at, const std::function<bool(double)> &holds,
                     double resolution) {
    while (std::abs(fails_at - holds_at) >
           resolution * std::max(std::abs(holds_at), std::abs(fails_at))) {
        const double middle = 0.5 * (holds_at + fails_at);
        (holds(middle) ? holds_at : fails_at) = middle;
    }
    return holds_at;
}

FailureLine measured(const TriedLine &tried) {
    FailureLine line = tried.line;
    line.measured = measurement(tried);
    return line;
}

std::string with_unit(double value, const char *unit) {
    return fmt::format("{:g} {}", value, unit);
}

} // namespace springdrive::limits
