// What the symbols and channels of the window mean: one home for the texts of their tooltips.
//
// Parameters of the tuning are described in engine/control/tuning.h, limits in
// engine/servo/safety_limits.h; here they only get the paper's name for them.
#pragma once

#include "engine/session/telemetry_history.h"

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

} // namespace springdrive::app
