#include "engine/study/methods/task.h"

#include <fmt/core.h>

namespace springdrive::study {

std::string unless_level(std::string_view key, double value, Scale scale) {
    return unless_from_to(key, value, scale == Scale::logarithmic ? kMinRatioTyped : -kMaxTyped,
                          kMaxTyped);
}

std::string unless_above(std::string_view key, double value, double minimum) {
    return value > minimum && std::isfinite(value)
               ? std::string()
               : fmt::format("{} is {:g}; it must be a finite number above {:g}", key, value,
                             minimum);
}

std::string unless_finite(std::string_view key, std::span<const double> values) {
    for (const double value : values) {
        if (!std::isfinite(value)) {
            return fmt::format("{} has {:g}; each must be a number", key, value);
        }
    }
    return {};
}

std::string unless_rising(std::string_view key, std::span<const double> levels,
                          std::size_t fewest) {
    if (levels.size() < fewest) {
        return fmt::format("{} has {} levels; it must have at least {}", key, levels.size(),
                           fewest);
    }
    if (std::string error = unless_finite(key, levels); !error.empty()) {
        return error;
    }
    for (std::size_t i = 1; i < levels.size(); ++i) {
        if (levels[i] <= levels[i - 1]) {
            return fmt::format("{} has {:g} after {:g}; each must be above the one before", key,
                               levels[i], levels[i - 1]);
        }
    }
    return {};
}

std::string first_of(std::initializer_list<std::string> errors) {
    for (const std::string &error : errors) {
        if (!error.empty()) {
            return error;
        }
    }
    return {};
}

} // namespace springdrive::study
