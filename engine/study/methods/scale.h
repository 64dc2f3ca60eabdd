// The scale on which levels of a stimulus are spaced, stepped and fitted.
#pragma once

#include "base/field.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>

namespace springdrive::study {

enum class Scale : std::uint8_t {
    linear,      ///< differences count: u = x
    logarithmic, ///< ratios count: u = ln x, so levels are above 0
};

/// By the number of the scale, as in protocol files.
inline constexpr std::array<std::string_view, 2> kScaleNames{"linear", "logarithmic"};

/// Levels and slopes that people type: what lies beyond is a slip of the keyboard in every unit
/// that a protocol has.
inline constexpr double kMaxTyped = 1e6;
inline constexpr double kMinRatioTyped = 1e-6; ///< of what must be above 0
inline constexpr NumberRange kTypedLevel{-kMaxTyped, kMaxTyped};

/// u(x). @pre level > 0 on a logarithmic scale
[[nodiscard]] inline double on_scale(Scale scale, double level) {
    return scale == Scale::linear ? level : std::log(level);
}

/// x(u), the inverse of `on_scale`.
[[nodiscard]] inline double level_from(Scale scale, double on_scale) {
    return scale == Scale::linear ? on_scale : std::exp(on_scale);
}

// The lines in which a specification is refused: key, value and range.

/// "KEY is VALUE; it must be from …" unless it can be a typed level: within `kMaxTyped`, and on
/// a logarithmic scale not below `kMinRatioTyped`.
[[nodiscard]] std::string unless_level(std::string_view key, double value, Scale scale);

/// "KEY is VALUE; it must be a finite number above MINIMUM" if it is not, or not finite; else
/// empty.
[[nodiscard]] std::string unless_above(std::string_view key, double value, double minimum);

/// Refuses levels that are fewer than `fewest`, not finite or not rising; else empty.
[[nodiscard]] std::string unless_rising(std::string_view key, std::span<const double> levels,
                                        std::size_t fewest);

/// Refuses values that are not finite; else empty.
[[nodiscard]] std::string unless_finite(std::string_view key, std::span<const double> values);

/// The first that is not empty.
[[nodiscard]] std::string first_of(std::initializer_list<std::string> errors);

} // namespace springdrive::study
