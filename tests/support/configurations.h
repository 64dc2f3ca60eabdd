// Where a device is tried: random configurations over its workspace.
#pragma once

#include "device/device_file.h"
#include "device/phantom/kinematics.h"

#include <optional>
#include <random>

namespace springdrive::testing {

/// Every coordinate uniform between −`largest` and `largest`.
inline Vector3 random_vector(std::mt19937_64 &random, double largest) {
    std::uniform_real_distribution<double> one(-largest, largest);
    const double x = one(random);
    const double y = one(random);
    return {x, y, one(random)};
}

/// Joint angles at a point of the workspace box that the tip can reach, uniform over the box.
inline Vector3 random_workspace_angles(const DeviceDescription &device, std::mt19937_64 &random) {
    while (true) {
        const Vector3 tip_m = device.workspace.centre_m +
                              device.workspace.size_m.cwiseProduct(random_vector(random, 0.5));
        const std::optional<Vector3> q_rad = joint_angles_rad(device.geometry, tip_m);
        if (q_rad) {
            return *q_rad;
        }
    }
}

} // namespace springdrive::testing
