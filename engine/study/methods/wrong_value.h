// The lines in which a specification is refused: key, value and range.
#pragma once

#include "engine/study/methods/scale.h"

#include <cstddef>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>

namespace springdrive::study {

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
