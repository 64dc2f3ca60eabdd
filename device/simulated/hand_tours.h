// Paths of a simulated hand for a device's commissioning: about in free space for its calibration,
// and to the joints' stops for its self-test.
#pragma once

#include "device/core/device_description.h"
#include "device/simulated/hand.h"

#include <functional>

namespace springdrive::simulated {

/// For a device's calibration: from where the tip is, around the middle of the workspace, in all
/// directions, slowly: at most some 0.2 m/s.
[[nodiscard]] HandPath calibration_tour(const device::DeviceDescription &device,
                                        const Vector3 &start_m, double duration_s);

/// What begins it: given the longest that it may last, returns how long it lasts [s].
/// @param hand    null: empty
/// @param device  like the hand, outlives what is returned
[[nodiscard]] std::function<double(double)>
calibration_tour_of(HandControl *hand, const device::DeviceDescription &device);

/// For a device's self-test, to those stops of the joints that the tip can reach from within the
/// workspace. From the zero pose's tip: to both stops of the base joint, to both of the angle
/// between the links, to the lower one of the third joint, and back.
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
