// Servo rates from 250 Hz to 20 kHz: how near the rendered stiffness comes to the paper's (12), how
// true the force's direction is while the tip moves, and how much of a processor that takes.
//
// The cost is a measured tick of the whole servo, in contact, times the ticks in a millisecond.
// A cross is a rate at which the loop is unstable on one of the device's motors.
#pragma once

#include "engine/lab/charts/chart_setting.h"
#include "engine/lab/rig/work_point.h"

namespace springdrive::charts {

/// The stiffness against (12), measured by sine sweep on the simulated motor.
/// @throw InputError where the safety monitor stops the servo that is timed.
[[nodiscard]] rig::WorkPrecisionChart servo_rate_stiffness_chart(const ChartSetting &setting,
                                                                 const ChartProgress &progress);

/// The direction of the transpose map's force, at a third, once and three times the tuning's λ.
/// @throw InputError as the one above, and for a tuning without static stiffness.
[[nodiscard]] rig::WorkPrecisionChart servo_rate_direction_chart(const ChartSetting &setting,
                                                                 const ChartProgress &progress);

} // namespace springdrive::charts
