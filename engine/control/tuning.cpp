#include "engine/control/tuning.h"

#include "base/field.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace springdrive::control {

namespace {

/// The enumerator that has that name.
template <typename Enum, typename Names>
std::optional<Enum> numbered(const Names &names, std::string_view name) {
    const auto found = std::ranges::find(names, name);
    return found == names.end() ? std::nullopt
                                : std::optional(static_cast<Enum>(found - names.begin()));
}

} // namespace

// Written so that a NaN lies in no range.
bool lies_in_range(const Parameter &parameter, const Tuning &tuning) noexcept {
    const double value = tuning.*parameter.value;
    return value >= parameter.minimum && value <= parameter.maximum;
}

bool is_valid(const Tuning &tuning) noexcept {
    return std::all_of(kParameters.begin(), kParameters.end(),
                       [&tuning](const Parameter &p) { return lies_in_range(p, tuning); });
}

std::string validate(const Tuning &tuning) {
    for (const Parameter &parameter : kParameters) {
        if (std::string wrong = unless_from_to(parameter.name, tuning.*parameter.value,
                                               parameter.minimum, parameter.maximum);
            !wrong.empty()) {
            return wrong;
        }
    }
    return {};
}

std::optional<MotionMap> motion_map_named(std::string_view name) {
    return numbered<MotionMap>(kMotionMapNames, name);
}

std::optional<AlphaMode> alpha_mode_named(std::string_view name) {
    return numbered<AlphaMode>(kAlphaModeNames, name);
}

namespace {

constexpr std::string_view kNoUnit = "–";

/// With so many significant digits, but never fewer than stand before the point.
double rounded(double value, int digits) {
    const auto before_point = static_cast<int>(fmt::formatted_size("{:.0f}", std::abs(value)));
    const std::string text = fmt::format("{:.{}e}", value, std::max(digits, before_point) - 1);
    double result = value;
    std::from_chars(text.data(), text.data() + text.size(), result);
    return result;
}

/// Two different numbers as different texts.
std::pair<std::string, std::string> told_apart(double before, double after) {
    constexpr int kFewest = 3;
    int digits = kFewest;
    while (digits < std::numeric_limits<double>::max_digits10 &&
           rounded(before, digits) == rounded(after, digits)) {
        ++digits;
    }
    return {fmt::format("{}", rounded(before, digits)), fmt::format("{}", rounded(after, digits))};
}

bool acts(const Parameter &parameter, const Tuning &tuning) {
    return parameter.value != &Tuning::alpha_rad2_per_m2 || tuning.alpha_mode == AlphaMode::by_hand;
}

} // namespace

std::vector<TuningChange> changes_between(const Tuning &before, const Tuning &after) {
    std::vector<TuningChange> changes;
    for (const Parameter &parameter : kParameters) {
        const double from = before.*parameter.value;
        const double to = after.*parameter.value;
        if (from != to && (acts(parameter, before) || acts(parameter, after))) {
            auto [from_text, to_text] = told_apart(from, to);
            changes.push_back({.name = parameter.name,
                               .symbol = parameter.symbol,
                               .before = std::move(from_text),
                               .after = std::move(to_text),
                               .unit = parameter.unit == kNoUnit ? "" : parameter.unit});
        }
    }
    const auto compare = [&](std::string_view name, std::string_view symbol, auto Tuning::*choice) {
        if (before.*choice != after.*choice) {
            changes.push_back({.name = name,
                               .symbol = symbol,
                               .before = std::string(label_of(before.*choice)),
                               .after = std::string(label_of(after.*choice)),
                               .unit = ""});
        }
    };
    compare("map", "map", &Tuning::map);
    compare("alpha_mode", "source", &Tuning::alpha_mode);
    return changes;
}

std::string text_of(const std::vector<TuningChange> &changes) {
    if (changes.empty()) {
        return "no difference";
    }
    std::string text;
    for (const TuningChange &change : changes) {
        fmt::format_to(std::back_inserter(text), "{}{} {} → {}{}{}", text.empty() ? "" : ", ",
                       change.symbol, change.before, change.after, change.unit.empty() ? "" : " ",
                       change.unit);
    }
    return text;
}

Tuning with_gains_of(const Tuning &active, const Tuning &preset) {
    Tuning result = active;
    for (double Tuning::*gain : kGainsOfPresets) {
        result.*gain = preset.*gain;
    }
    return result;
}

} // namespace springdrive::control
