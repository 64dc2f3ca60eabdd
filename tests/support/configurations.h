// Random configurations over a device's workspace.
#pragma once

#include "device/core/device_description.h"
#include "device/core/phantom/kinematics.h"
#include "tests/support/random_vector.h"

#include <optional>
#include <random>

namespace springdrive::testing {

/// Joint angles at a point of the workspace box that the tip can reach, uniform over the box.
inline Vector3 random_workspace_angles(const device::DeviceDescription &device,
                                       std::mt19937_64 &random) {
    while (true) {
        const Vector3 tip_m = device.workspace.centre_m +
                              device.workspace.size_m.cwiseProduct(random_vector(random, 0.5));
        const std::optional<Vector3> q_rad = device::joint_angles_rad(device.geometry, tip_m);
        if (q_rad) {
            return *q_rad;
        }
    }
}

} // namespace springdrive::testing
