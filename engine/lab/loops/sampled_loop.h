// Stability of one motor under the sampled law (10), DESIGN section 4.
//
// Between samples the plant is linear and e_W stands still, but for one step where the delay has a
// fraction, so that its motion over a period is exact; the filter and the held outputs are
// difference equations. Together they are one matrix that takes the state at one sample to the
// state at the next, and its eigenvalues decide.
#pragma once

#include "device/core/device_file.h"
#include "device/core/motor/rotor_load.h"
#include "engine/lab/loops/rendered_stiffness.h"

#include <Eigen/Core>

namespace springdrive::loops {

/// A motor that moves freely, but for its load and the hand on it:
///
///   L di/dt = e_W − dR i − k_T θ̇
///   (J_m + J_device + J_hand) θ̈ = k_T i − (b_device + b_hand) θ̇ − (k_device + k_hand) θ
///   e_W[k] = η k_T v[k] − (1 − η)(K_D v[k] + K_P θ[k]),   applied from (k + d) T to (k + d + 1) T
///
/// with η of the tuning: (10) under (17). A mode of the transpose map with eigenvalue a of α JᵀJ is
/// the loop with η = 1 − a.
struct SampledLoop {
    SpringDrive drive;
    device::RotorLoad device; ///< beside the rotor's own inertia
    device::RotorLoad hand;   ///< none: the device runs free
};

/// What the motor of a joint carries of the device while all joints but its own stand still, at the
/// zero pose: M(0)/N² and the joint's viscous friction. Without the rotor.
/// @param joint  0, 1 or 2
[[nodiscard]] device::RotorLoad device_load(const device::DeviceDescription &device, int joint);

/// The map over one period, for the states
///
///   [ θ[k],  θ[k] − θ[k−1],  θ̇[k],  i[k],  v[k−1],  e_W[k−1] … e_W[k−⌈d⌉] ]
///
/// The difference stands in the place of θ[k−1], the same states in other coordinates: so position
/// alone, where nothing pulls it back, is the first column and can be left out exactly.
[[nodiscard]] Eigen::MatrixXd one_period_map(const SampledLoop &loop);

/// The largest |eigenvalue| of that map: by how much the slowest mode shrinks or grows in a period.
/// Where neither K_P (1 − η) nor a spring pulls on θ, the motor may rest anywhere; that one
/// eigenvalue of exactly 1 does not count.
[[nodiscard]] double largest_eigenvalue(const SampledLoop &loop);

/// True where every motion dies out. A mass that moves on for ever, as it does in free space
/// without any friction, does not.
[[nodiscard]] bool is_stable(const SampledLoop &loop);

} // namespace springdrive::loops
