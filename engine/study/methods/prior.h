// What is known about one parameter of a psychometric function before a study: a density over a
// range, and the grid on which it is evaluated.
#pragma once

#include "engine/study/methods/scale.h"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::study {

enum class Density : std::uint8_t { uniform, normal };

/// By the number of the density, as in protocol files.
inline constexpr std::array<std::string_view, 2> kDensityNames{"uniform", "normal"};

/// The density is one of u(value), on the scale: uniform on a logarithmic scale means that equal
/// ratios are equally likely. It is 0 outside the range, which a normal density is cut to.
struct Prior {
    Scale scale = Scale::linear;
    double minimum = 0.0;
    double maximum = 1.0; ///< equal to `minimum` if the value is known
    Density density = Density::uniform;
    double mean = 0.5;      ///< of a normal density before it is cut: a value, not its logarithm
    double deviation = 1.0; ///< of a normal density: on the scale, so of ln(value) on a logarithmic

    friend bool operator==(const Prior &, const Prior &) = default;
};

inline constexpr auto kPriorFields = std::to_array<Field<Prior>>({
    {"scale", choice_of<&Prior::scale>(kScaleNames),
     "on which the density is one; without it the method's, of the slope logarithmic", kDerived},
    {"density", choice_of<&Prior::density>(kDensityNames), "of what is thought likely"},
    {"minimum", &Prior::minimum,
     "of what is thought possible; without it 0, of guess the task's, of lapse 0.02", kTypedLevel,
     "", kDerived},
    {"maximum", &Prior::maximum,
     "the same as `minimum` if it is known; without it 1, of guess and lapse as there", kTypedLevel,
     "", kDerived},
    {"mean", &Prior::mean, "of a normal density before it is cut to the range", kTypedLevel},
    {"deviation", &Prior::deviation,
     "of a normal density; on a logarithmic scale that of the logarithm", 0.0, kMaxTyped},
});

/// The prior of a value that is known.
[[nodiscard]] Prior known(double value);

/// Empty if the prior can be used; else "NAME.KEY is VALUE; it must be …".
[[nodiscard]] std::string validate(const Prior &prior, std::string_view name);

/// Nodes of the midpoint rule: the range is cut into cells of equal width on the scale, and each
/// node stands for its cell.
struct PriorGrid {
    std::vector<double> values;  ///< the middles of the cells
    std::vector<double> weights; ///< of the cells, sum 1
};

/// @pre points >= 1. A known value has one node, whatever `points` is.
[[nodiscard]] PriorGrid grid_of(const Prior &prior, int points);

/// The value below which the prior has that share of its weight. @pre 0 <= share <= 1
[[nodiscard]] double quantile(const Prior &prior, double share);

} // namespace springdrive::study
