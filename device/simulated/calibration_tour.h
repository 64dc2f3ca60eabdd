// The path of a simulated hand that moves the tip about in free space, for a device's calibration.
#pragma once

#include "device/core/device_description.h"
#include "device/simulated/hand_path.h"

namespace springdrive::simulated {

/// From where the tip is, around the middle of the workspace, in all directions, slowly: at most
/// some 0.2 m/s.
[[nodiscard]] HandPath calibration_tour(const device::DeviceDescription &device,
                                        const Vector3 &start_m, double duration_s);

} // namespace springdrive::simulated
