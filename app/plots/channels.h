// What the symbols and channels of the window mean, one home for the texts of their tooltips; and
// how a channel looks in every plot: its colour and line, its label, and the unit that it is shown
// in.
//
// Parameters of the tuning are described in engine/control/tuning.h, limits in
// engine/servo/safety_limits.h; here they only get the paper's name for them.
#pragma once

#include "app/plots/canvas.h"
#include "engine/session/telemetry_history.h"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace springdrive::app {

struct Symbol {
    /// Of a channel or parameter, without unit, motor and axis: "theta_Sd"; or of a derived value
    /// in a panel: "K_DC".
    std::string_view name;
    std::string_view symbol; ///< as written in panels and in the paper; may be empty
    /// In plain words; empty for parameters and derived channels, which have their own.
    std::string_view meaning;
    std::string_view equations; ///< of the paper: "(10), (12)"; empty: the paper has none
    std::string_view paper;     ///< what the paper calls it; empty: it has no name there
};

/// All of them.
[[nodiscard]] std::span<const Symbol> symbols();

/// Null if there is none of that name.
[[nodiscard]] const Symbol *symbol_named(std::string_view name);

/// "tip_x" of "tip_x_m".
[[nodiscard]] std::string without_unit(const session::Channel &channel);

/// "theta_Sd" of "theta_Sd1_rad", "tip" of "tip_x_m": what all components have in common.
[[nodiscard]] std::string quantity_of(const session::Channel &channel);

/// Of a tooltip: name, meaning, unit, equations and the paper's name, a line each. Of a parameter
/// by its name in files, with its range; of a channel by its whole name; of others as in the table.
/// @param unit  of a value that is no parameter and no channel; empty: it has none
[[nodiscard]] std::string explanation_of(std::string_view name, std::string_view unit = {});

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
