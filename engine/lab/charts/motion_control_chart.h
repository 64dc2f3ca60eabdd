// The maps from the tip's set-point to the motors': inverse (18), and transpose (23) with α at its
// bound (29) in each tick, at the minimum bound of the workspace, or set by hand.
//
// The cost is that of a tick's whole law, from θ to e_W, with only this map. Forces are those at
// rest, over the workspace and over surfaces of all orientations. A cross is an α at which the
// servo's loop is unstable somewhere in the workspace.
#pragma once

#include "engine/lab/charts/chart.h"

namespace springdrive::charts {

/// The angle from the normal to the force, for encoders from coarse to fine.
/// @throw InputError for a tuning without static stiffness.
[[nodiscard]] SpeedAccuracyChart motion_direction_chart(const ChartSetting &setting,
                                                        const ChartProgress &progress);

/// The mean compliance of a wall. The transpose map with α by hand has a point for each α.
/// @throw InputError for a tuning without static stiffness.
[[nodiscard]] SpeedAccuracyChart motion_stiffness_chart(const ChartSetting &setting,
                                                        const ChartProgress &progress);

} // namespace springdrive::charts
