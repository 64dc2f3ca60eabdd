// The plant's integrators where joints stick and slip: a tip that is pressed onto a plate against
// Coulomb friction, held still and let go. What a step costs against the error of the force, as in
// integrator_chart.h.
//
// Friction is τ_c sign(q̇) to explicit methods. Methods that need a smooth f get τ_c tanh(q̇/width),
// as narrow as they bear it. Ours has real sticking, and so has CVODE where it goes from one change
// of sticking and sliding to the next, which at a tight tolerance is the reference, too.
#pragma once

#include "engine/lab/charts/chart_setting.h"
#include "engine/lab/rig/work_point.h"

namespace springdrive::charts {

/// @throw InputError where the device does not reach the place of the press
[[nodiscard]] rig::WorkPrecisionChart friction_integrator_chart(const ChartSetting &setting,
                                                                const ChartProgress &progress);

/// Steps of the chart, in a servo period: down to about 16 µs at 1 kHz.
inline constexpr int kMostFrictionSubSteps = 64;

} // namespace springdrive::charts
