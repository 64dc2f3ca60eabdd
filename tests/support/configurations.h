// Random vectors, and random configurations over a device's workspace.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"
#include "device/core/phantom/kinematics.h"

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

inline Vector3 random_direction(std::mt19937_64 &random) {
    std::normal_distribution<double> coordinate;
    const double x = coordinate(random);
    const double y = coordinate(random);
    const double z = coordinate(random);
    return Vector3(x, y, z).normalized();
}

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
