// The scale on which levels of a stimulus are spaced, stepped and fitted.
#pragma once

#include <cmath>
#include <cstdint>

namespace springdrive::study {

enum class Scale : std::uint8_t {
    linear,      ///< differences count: u = x
    logarithmic, ///< ratios count: u = ln x, so levels are above 0
};

/// u(x). @pre level > 0 on a logarithmic scale
[[nodiscard]] inline double on_scale(Scale scale, double level) {
    return scale == Scale::linear ? level : std::log(level);
}

/// x(u), the inverse of `on_scale`.
[[nodiscard]] inline double level_from(Scale scale, double on_scale) {
    return scale == Scale::linear ? on_scale : std::exp(on_scale);
}

} // namespace springdrive::study
