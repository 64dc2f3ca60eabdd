// What the charts of servo rates measure at one rate.
#pragma once

#include "engine/lab/charts/charts.h"
#include "engine/lab/loops/rendered_stiffness.h"

namespace springdrive::charts {

/// |K_measured − K(12)|/|K(12)|, root mean square over `points` frequencies from 2 to 100 Hz, at
/// least two, evenly spaced on a logarithmic scale. Above, the hand holds the tip rather than
/// perceives its stiffness.
[[nodiscard]] double stiffness_error(const loops::SpringDrive &drive, int points);

/// The largest angle between normal and force over all normals in the plane of the links, base
/// locked, for a tip that vibrates at `control::kPerceived_Hz` under the transpose map [rad].
[[nodiscard]] double perceived_direction_error_rad(const device::DeviceDescription &device,
                                                   const control::Tuning &tuning, double period_s);

/// Whether every motor's loop is stable at a period with a locked set-point.
[[nodiscard]] bool is_stable_on_all_motors(const device::DeviceDescription &device,
                                           const control::Tuning &tuning, double period_s,
                                           double delay_periods);

/// A tick of the whole servo, from encoder counts to voltages, while the simulated hand slides over
/// a sphere of 20,480 triangles. The simulated device is not timed.
/// @throw InputError where the safety monitor trips.
[[nodiscard]] Cost cost_of_servo_tick(const ChartSetting &setting);

} // namespace springdrive::charts
