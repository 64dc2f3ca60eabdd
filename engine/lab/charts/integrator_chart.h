// The plant's integrators in hard contact: the error of the force over a contact transient, and the
// cost of a millisecond of it. A point for each step, a line for each method, a cross where it
// diverged.
//
// All methods integrate the same smooth plant (plant_equations.h). "Ours" is the simulated device
// itself, which additionally checks for friction, stops and limits.
#pragma once

#include "engine/lab/charts/chart.h"

namespace springdrive::charts {

/// A pen grip presses the tip onto the plate.
/// @throw InputError where the press is out of the device's reach
[[nodiscard]] SpeedAccuracyChart integrator_chart(const ChartSetting &setting,
                                                  const ChartProgress &progress);

/// A vice presses it, stiff enough for Euler's methods to diverge at the longest steps.
/// @throw InputError as `integrator_chart`
[[nodiscard]] SpeedAccuracyChart stiff_integrator_chart(const ChartSetting &setting,
                                                        const ChartProgress &progress);

/// Maximum number of steps in a servo period: down to about a microsecond at 1 kHz.
inline constexpr int kMaxSubSteps = 1024;

} // namespace springdrive::charts
