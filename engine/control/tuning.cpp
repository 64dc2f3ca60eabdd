#include "engine/control/tuning.h"

#include "base/field.h"

#include <algorithm>

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

} // namespace springdrive::control
