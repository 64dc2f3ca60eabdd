// The groups of rows that are found by trials; each is made in a file of its own.
#pragma once

#include "device/core/device_description.h"
#include "engine/lab/limits/method_limits/method_limit.h"
#include "engine/lab/loops/stability_case.h"

#include <vector>

namespace springdrive::limits {

// Where resistance cancellation (6) fails: dR ≤ 0.

/// For the second motor, its rotor held: a small current behind the amplifier grows where R̂
/// exceeds R(T, θ), because of cold, of the commutator or of a wrong setting; without and with the
/// winding guard.
[[nodiscard]] std::vector<LimitTrial> cancellation_trials(const device::DeviceDescription &device);

// Where inverse kinematics (18) fails: near q₂ − q₃ = ±90° and r = 0.

[[nodiscard]] std::vector<LimitTrial> inverse_trials(const device::DeviceDescription &device);

// Where the transpose map (23) no longer shapes the stiffness: the force's direction above about λ.

/// The name of the method in the table.
inline constexpr const char *kTransposeKinematics = "transpose kinematics (23)";

/// The frequency of vibration above which forces deviate from the normal by more than the angle
/// that the paper quotes as perceptible. Predicted by the sampled form of direction_spectrum.h,
/// measured by vibrating the motors under the law itself.
[[nodiscard]] LimitTrial direction_trial(const loops::StabilityCase &which);

// The steps above which integrators of the plant are unstable.

/// For a winding with its rotor held, and for the contact mode: a rotor with its load against the
/// inductive stiffness K_L (4) of a winding with a constant set-point.
[[nodiscard]] std::vector<LimitTrial> integrator_trials(const loops::StabilityCase &which);

// Where a penalty method fails, which uses the closest point of a mesh.

/// Thin walls, fast tips and edges.
[[nodiscard]] std::vector<LimitTrial> closest_point_trials();

// Where the proxy fails, or was tried without a failure.

/// Thin walls, fast tips, concave edges and corners, cracks, degenerate triangles, and tips that
/// start inside.
[[nodiscard]] std::vector<LimitTrial> proxy_trials();

// Where the servo fails, or stops before it does: missed ticks, jitter, a late or lost device, a
// hung window, a change of scene and a hand that releases.

/// At 1 kHz, by the servo's own loop on simulated devices.
[[nodiscard]] std::vector<LimitTrial> servo_trials(const loops::StabilityCase &which);

// What happens when a pressing hand releases the device.

/// The contact then expels the tip. The force from which on that trips the limit of tip speed: with
/// the limit of the device file, and with a lower one.
/// @param which  its hands are ignored: a firm one presses
[[nodiscard]] std::vector<LimitTrial> release_trials(const loops::StabilityCase &which);

// Where motors and their amplifiers reach their limits: voltage, current, force and heat.

inline constexpr const char *kMotorMethod = "motor";

/// Limits of the amplifier.
[[nodiscard]] std::vector<LimitTrial> amplifier_trials(const device::DeviceDescription &device);

/// Where the servo's last stage limits e_W before the motor's or the device's limits are reached.
[[nodiscard]] std::vector<LimitTrial> limiter_trials(const loops::StabilityCase &which);

/// Limits of winding temperature, and the effect of warming on a held contact.
[[nodiscard]] std::vector<LimitTrial> heat_trials(const device::DeviceDescription &device);

} // namespace springdrive::limits
