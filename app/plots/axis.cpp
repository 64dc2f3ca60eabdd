#include "app/plots/axis.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace springdrive::app {

namespace {

constexpr double kRoundOff = 1e-9; // of a step

/// Far below any span that can be shown; keeps an axis from collapsing to a point.
double min_length(double from, double to) {
    return 1e-9 * std::max({std::abs(from), std::abs(to), 1e-6});
}

/// Whether an axis can be drawn and labelled: zooming and moving end before that.
bool is_usable(const Axis &axis) {
    constexpr double kMax = 1e100;
    if (!(std::abs(axis.from) < kMax && std::abs(axis.to) < kMax)) {
        return false; // a NaN, too
    }
    if (axis.is_logarithmic) {
        return axis.from > 1.0 / kMax && axis.to / axis.from > 1.0 + 1e-9;
    }
    return axis.to - axis.from > min_length(axis.from, axis.to);
}

std::vector<Tick> linear_ticks(const Axis &axis, int most) {
    const double length = axis.to - axis.from;
    const double step = round_up(length / std::max(1, most));
    std::vector<Tick> ticks;
    const double first = std::ceil(axis.from / step - kRoundOff);
    const double last = std::floor(axis.to / step + kRoundOff);
    for (int i = 0; i <= static_cast<int>(last - first); ++i) {
        const double value = (first + i) * step;
        ticks.push_back({value, number_at_step(value, step)});
    }
    return ticks;
}

/// Powers of ten are labelled, or every second or third of them; 2 to 9 are not, unless there are
/// less than two powers.
std::vector<Tick> logarithmic_ticks(const Axis &axis, int most) {
    const int first = static_cast<int>(std::floor(std::log10(axis.from) + kRoundOff));
    const int last = static_cast<int>(std::ceil(std::log10(axis.to) - kRoundOff));
    const int labelled_each = std::max(1, (last - first + most) / std::max(1, most));
    const bool labels_all = std::log10(axis.to / axis.from) < 1.3;
    std::vector<Tick> ticks;
    bool has_label = false;
    for (int power = first; power <= last; ++power) {
        for (int digit = 1; digit <= 9; ++digit) {
            const double value = digit * std::pow(10.0, power);
            if (value < axis.from * (1.0 - kRoundOff) || value > axis.to * (1.0 + kRoundOff)) {
                continue;
            }
            const bool is_labelled = digit == 1 ? (power - first) % labelled_each == 0
                                                : labels_all && (digit == 2 || digit == 5);
            has_label = has_label || is_labelled;
            ticks.push_back(
                {value, is_labelled ? fmt::format("{:g}", value) : std::string(), digit != 1});
        }
    }
    // Between two round values: as on an axis that is not logarithmic.
    return has_label ? ticks : linear_ticks(axis, most);
}

} // namespace

double Axis::share(double value) const {
    if (is_logarithmic) {
        return std::log(std::max(value, 1e-300) / from) / std::log(to / from);
    }
    return (value - from) / (to - from);
}

double Axis::value(double share) const {
    return is_logarithmic ? from * std::pow(to / from, share) : from + share * (to - from);
}

Axis Axis::zoomed(double share, double factor) const {
    Axis result = *this;
    result.from = value(share * (1.0 - factor));
    result.to = value(share + (1.0 - share) * factor);
    return is_usable(result) ? result : *this;
}

Axis Axis::moved(double share) const {
    Axis result = *this;
    result.from = value(share);
    result.to = value(1.0 + share);
    return is_usable(result) ? result : *this;
}

double round_up(double value) {
    const double decade = std::pow(10.0, std::floor(std::log10(value)));
    for (const double factor : {1.0, 2.0, 5.0}) {
        if (factor * decade >= value * (1.0 - kRoundOff)) {
            return factor * decade;
        }
    }
    return 10.0 * decade;
}

Axis round_axis(double minimum, double maximum) {
    if (!(minimum <= maximum) || !std::isfinite(minimum) || !std::isfinite(maximum)) {
        return {0.0, 1.0};
    }
    if (maximum - minimum <= min_length(minimum, maximum)) {
        const double margin = minimum == 0.0 ? 1.0 : 0.1 * std::abs(minimum);
        return {minimum - margin, maximum + margin};
    }
    const double step = round_up(0.125 * (maximum - minimum));
    return {step * std::floor(minimum / step + kRoundOff),
            step * std::ceil(maximum / step - kRoundOff)};
}

std::vector<Tick> ticks_of(const Axis &axis, int most) {
    if (!(axis.to > axis.from)) {
        return {};
    }
    return axis.is_logarithmic ? logarithmic_ticks(axis, most) : linear_ticks(axis, most);
}

std::string number_at_step(double value, double step) {
    const double magnitude = std::max(std::abs(value), step);
    if (magnitude >= 1e6 || magnitude < 1e-4) {
        // Digits down to the step.
        const auto exponent = [](double number) {
            return static_cast<int>(std::floor(std::log10(number) + kRoundOff));
        };
        const int digits = exponent(magnitude) - exponent(step);
        return fmt::format("{:.{}e}", value, std::clamp(digits, 0, 15));
    }
    const int decimals = static_cast<int>(std::ceil(-std::log10(step) - kRoundOff));
    return fmt::format("{:.{}f}", value == 0.0 ? 0.0 : value, std::clamp(decimals, 0, 15));
}

} // namespace springdrive::app
