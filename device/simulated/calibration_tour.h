// The path of a simulated hand that moves the tip about in free space, for a device's calibration.
#pragma once

#include "device/core/device_description.h"
#include "device/simulated/hand_control.h"

#include <functional>

namespace springdrive::simulated {

/// From where the tip is, around the middle of the workspace, in all directions, slowly: at most
/// some 0.2 m/s.
[[nodiscard]] HandPath calibration_tour(const device::DeviceDescription &device,
                                        const Vector3 &start_m, double duration_s);

/// What begins it: given the longest that it may last, returns how long it lasts [s].
/// @param hand    null: empty
/// @param device  like the hand, outlives what is returned
[[nodiscard]] std::function<double(double)>
calibration_tour_of(HandControl *hand, const device::DeviceDescription &device);

} // namespace springdrive::simulated
