// The plant's integrators where joints stick and slip: a tip is pressed onto a plate against
// Coulomb friction, held and released. The cost of a step against the error of the force, as in
// integrator_chart.h.
//
// Explicit methods use friction τ_c sign(q̇). Methods that need a smooth f use τ_c tanh(q̇/width),
// as narrow as they tolerate. The simulated device has true sticking, and so has CVODE restarted at
// each transition between sticking and sliding, which at a tight tolerance is also the reference.
#pragma once

#include "engine/lab/charts/chart.h"

namespace springdrive::charts {

/// @throw InputError where the press is out of the device's reach
[[nodiscard]] SpeedAccuracyChart friction_integrator_chart(const ChartSetting &setting,
                                                           const ChartProgress &progress);

/// Maximum number of steps in a servo period: down to about 16 µs at 1 kHz.
inline constexpr int kMaxFrictionSubSteps = 64;

} // namespace springdrive::charts
