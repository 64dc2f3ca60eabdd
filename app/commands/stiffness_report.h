// What `springdrive stiffness` tells people: levels, corners, stability, and a table.
#pragma once

#include "device/device_file.h"
#include "engine/analysis/stiffness_sweep.h"

#include <ostream>
#include <vector>

namespace springdrive {

/// @param drive  the device's first motor and its tuning, of which `points` is the sweep
void write_stiffness_report(std::ostream &out, const DeviceDescription &device,
                            const SpringDrive &drive, const std::vector<StiffnessPoint> &points);

} // namespace springdrive
