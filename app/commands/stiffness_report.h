// The report of `springdrive stiffness`: levels, corner frequencies, stability, and a table.
#pragma once

#include "device/core/device_description.h"
#include "engine/lab/loops/stiffness_sweep.h"

#include <ostream>
#include <vector>

namespace springdrive::app {

/// @param drive  the device's first motor and its tuning, of which `points` is the sweep
void write_stiffness_report(std::ostream &out, const device::DeviceDescription &device,
                            const loops::SpringDrive &drive,
                            const std::vector<loops::StiffnessPoint> &points);

} // namespace springdrive::app
