// How a channel looks in every plot: its colour and line, its label, and the unit that it is shown
// in.
#pragma once

#include "app/plots/canvas.h"

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace springdrive::app {

/// The same for good, whatever else is shown: a map keeps its colour and name, whether it is in use
/// or not. Channels of one colour differ in their dashes.
struct ChannelLook {
    std::string label;
    Stroke stroke;
};

[[nodiscard]] const ChannelLook &look_of(std::size_t channel);

/// A unit, and its value per SI unit.
struct ShownUnit {
    std::string_view name;
    double per_si = 1.0;
};

/// Degrees for radians, millimetres for metres, and so on; the SI unit itself if `in_si`.
[[nodiscard]] ShownUnit shown_unit(std::size_t channel, bool in_si);

/// A level drawn across plots of a channel.
struct PlotLevel {
    double value_si = 0.0;
    std::string_view label;
};
[[nodiscard]] std::optional<PlotLevel> level_of(std::size_t channel);

/// A plot that chooses its own range of values makes it at least this long, so that noise does not
/// fill it [SI].
[[nodiscard]] double min_range_of_interest(std::size_t channel);

/// A plot that chooses its own range of values goes no further, as short peaks would flatten the
/// rest: for angles between forces, 60°.
[[nodiscard]] double greatest_of_interest(std::size_t channel);

} // namespace springdrive::app
