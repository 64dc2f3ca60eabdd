// The path of a simulated hand that moves the tip to those stops of the joints that it can reach
// from within the workspace, for a device's self-test.
#pragma once

#include "device/core/device_description.h"
#include "device/simulated/hand_path.h"

namespace springdrive::simulated {

/// From the zero pose's tip: to both stops of the base joint, to both of the angle between the
/// links, to the lower one of the third joint, and back.
/// @param start_m  where the hand is at time 0
/// @param rest_s   how long it stays there
[[nodiscard]] HandPath stop_tour(const device::DeviceDescription &device, const Vector3 &start_m,
                                 double rest_s = 0.0);

} // namespace springdrive::simulated
