// What the mouse reads in plots.
#pragma once

#include "app/plots/plot.h"

#include <string>

namespace springdrive::app {

/// Angle and radius at a place in a polar plot: "30.0°, 1.5 N".
[[nodiscard]] std::string polar_text(const PlotArea &area, ImVec2 place,
                                     const PlotSettings &settings);

} // namespace springdrive::app
