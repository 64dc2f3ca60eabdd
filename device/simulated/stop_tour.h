// The path of a simulated hand that moves the tip to those stops of the joints that it can reach
// from within the workspace, for a device's self-test.
#pragma once

#include "device/core/device_description.h"
#include "device/simulated/hand_control.h"

#include <functional>

namespace springdrive::simulated {

/// From the zero pose's tip: to both stops of the base joint, to both of the angle between the
/// links, to the lower one of the third joint, and back.
/// @param start_m  where the hand is at time 0
/// @param rest_s   how long it stays there
[[nodiscard]] HandPath stop_tour(const device::DeviceDescription &device, const Vector3 &start_m,
                                 double rest_s = 0.0);

/// What begins it: given the longest that it may last, returns how long it lasts [s].
/// @param hand    null: empty
/// @param device  like the hand, outlives what is returned
[[nodiscard]] std::function<double(double)> stop_tour_of(HandControl *hand,
                                                         const device::DeviceDescription &device);

} // namespace springdrive::simulated
