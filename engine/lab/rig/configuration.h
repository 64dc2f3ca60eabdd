// Whether a device can be held at given joint angles, to be measured there.
#pragma once

#include "device/core/device_description.h"

namespace springdrive::rig {

/// @throw InputError naming the angle, its value and its range in degrees, where the joint limits
///        do not allow `q_rad`, or where inverse kinematics would give other angles for that tip.
void check_configuration(const device::DeviceDescription &device, const Vector3 &q_rad);

} // namespace springdrive::rig
