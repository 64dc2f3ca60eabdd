// Servo rates from 250 Hz to 20 kHz: the error of the rendered stiffness against the paper's (12),
// the error of the force's direction while the tip moves, and the processor time.
//
// The cost is the measured time of a tick of the whole servo in contact, times the ticks in a
// millisecond. A cross is a rate at which the loop is unstable on one of the device's motors.
#pragma once

#include "engine/lab/charts/chart_setting.h"
#include "engine/lab/rig/chart_point.h"

namespace springdrive::charts {

/// The stiffness against (12), measured by sine sweep on the simulated motor.
/// @throw InputError where the safety monitor stops the timed servo.
[[nodiscard]] rig::SpeedAccuracyChart servo_rate_stiffness_chart(const ChartSetting &setting,
                                                                 const ChartProgress &progress);

/// The direction of the transpose map's force, at one third, one and three times the tuning's λ.
/// @throw InputError as the one above, and for a tuning without static stiffness.
[[nodiscard]] rig::SpeedAccuracyChart servo_rate_direction_chart(const ChartSetting &setting,
                                                                 const ChartProgress &progress);

} // namespace springdrive::charts
