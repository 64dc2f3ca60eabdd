// The plant's integrators in hard contact: the error of the force over a contact transient, and
// what a millisecond of it costs. A point for each step, a line for each method, a cross where it
// ran away.
//
// What the methods integrate is the same smooth plant (plant_equations.h). Ours is the simulated
// device as it runs, which looks for friction, stops and limits besides.
#pragma once

#include "engine/lab/charts/chart_setting.h"
#include "engine/lab/rig/work_point.h"

namespace springdrive::charts {

/// A pen grip presses the tip onto a plate.
/// @throw InputError where the device does not reach the place of the press
[[nodiscard]] rig::WorkPrecisionChart integrator_chart(const ChartSetting &setting,
                                                       const ChartProgress &progress);

/// A vice does, stiff enough for Euler's methods to run away at the longest steps.
/// @throw InputError as `integrator_chart`
[[nodiscard]] rig::WorkPrecisionChart stiff_integrator_chart(const ChartSetting &setting,
                                                             const ChartProgress &progress);

/// Steps of a chart, in a servo period: from all of it down to about a microsecond at 1 kHz.
inline constexpr int kMostSubSteps = 1024;

} // namespace springdrive::charts
