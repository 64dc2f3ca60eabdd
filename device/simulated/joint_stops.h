// The stops at the ends of the joints' travel: springs with dampers, one-sided.
#pragma once

#include "base/vector.h"
#include "device/core/device_file.h"

namespace springdrive::simulated {

/// What the stops do over a step: their springs by the secant of their energy, so that the work is
/// exact for the step. Their dampers act where a stop is pressed already when the step begins, so
/// that whether they do is not at stake while the step is solved.
struct StopTorque {
    Vector3 torque_Nm{Vector3::Zero()};           ///< of the springs
    Matrix3 damping_Nms_per_rad{Matrix3::Zero()}; ///< positive semidefinite
};

/// RT-safe.
[[nodiscard]] StopTorque stop_torque(const device::JointLimits &limits, const Vector3 &q_a_rad,
                                     const Vector3 &q_b_rad) noexcept;

/// What the springs hold [J].
[[nodiscard]] double stop_energy_J(const device::JointLimits &limits,
                                   const Vector3 &q_rad) noexcept;

} // namespace springdrive::simulated
