// The stops at the ends of the joints' travel: springs with dampers, one-sided.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"

namespace springdrive::simulated {

/// The stops' action over a step. The springs act by the secant of their energy, so that the work
/// over the step is exact. A damper acts if its stop is already pressed at the start of the step,
/// so that this does not change while the step is solved.
struct StopTorque {
    Vector3 torque_Nm{Vector3::Zero()};           ///< of the springs
    Matrix3 damping_Nms_per_rad{Matrix3::Zero()}; ///< positive semidefinite
};

/// RT-safe.
[[nodiscard]] StopTorque stop_torque(const device::JointLimits &limits, const Vector3 &q_a_rad,
                                     const Vector3 &q_b_rad) noexcept;

/// Energy stored in the springs [J].
[[nodiscard]] double stop_energy_J(const device::JointLimits &limits,
                                   const Vector3 &q_rad) noexcept;

} // namespace springdrive::simulated
