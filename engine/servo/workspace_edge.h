// The soft wall at the edge of the workspace: before each joint's stop, and before the links fold
// too far, a spring and a damper push back. They act directly on the motor torque, so no tuning
// disables them.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"

namespace springdrive::servo {

/// How far joint angles are beyond limits reduced by `margin_rad`: the joints, and the fold q₃ −
/// q₂. Positive beyond the upper limit, negative beyond the lower, zero within [rad].
struct BeyondLimits {
    Vector3 joint_rad{Vector3::Zero()};
    double fold_rad = 0.0;

    [[nodiscard]] double max_excess_rad() const noexcept;
};

/// RT-safe.
[[nodiscard]] BeyondLimits beyond_limits(const device::JointLimits &limits, const Vector3 &q_rad,
                                         double margin_rad) noexcept;

/// Joint torques of the soft wall [N·m]; zero within. RT-safe.
[[nodiscard]] Vector3 edge_torque_Nm(const device::DeviceDescription &device, const Vector3 &q_rad,
                                     const Vector3 &q_rate_rad_per_s) noexcept;

} // namespace springdrive::servo
