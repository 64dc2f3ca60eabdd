// The groups of experiments, each made in a file of its own, in the order of the table.
#pragma once

#include "device/core/device_description.h"
#include "engine/lab/limits/method_limits/experiment.h"

#include <fmt/core.h>

namespace springdrive::limits {

using Experiments = std::vector<Experiment>;

inline constexpr const char *kTransposeKinematics = "transpose kinematics (23)";
inline constexpr const char *kMotorMethod = "motor";

/// "0.1 Ω".
[[nodiscard]] inline std::string with_unit(double value, const char *unit) {
    return fmt::format("{:g} {}", value, unit);
}

/// Resistance cancellation (6), which fails at dR ≤ 0. For the second motor, its rotor held: a
/// small current behind the amplifier grows where R̂ exceeds R(T, θ), because of cold, of the
/// commutator or of a wrong setting; without and with the winding guard.
[[nodiscard]] Experiments cancellation_experiments(const device::DeviceDescription &device);

// Sampled loops: each limit by eigenvalues and by trials.

/// Drift compensation (10), and the change of e_W per encoder count.
[[nodiscard]] Experiments drift_experiments(const loops::StabilityCase &which);
/// The scale of the transpose map (23).
[[nodiscard]] Experiments alpha_experiments(const loops::StabilityCase &which);
/// The virtual wall of a current drive.
[[nodiscard]] Experiments wall_experiments(const loops::StabilityCase &which);

/// Inverse kinematics (18), near q₂ − q₃ = ±90° and r = 0.
[[nodiscard]] Experiments inverse_experiments(const device::DeviceDescription &device);

/// The frequency of vibration above which forces of the transpose map (23) deviate from the normal
/// by more than the angle that the paper quotes as perceptible. Predicted by the sampled form of
/// link_plane.h, measured by vibrating the motors under the law itself.
[[nodiscard]] Experiments direction_experiments(const loops::StabilityCase &which);

/// The steps above which integrators are unstable: for a winding with its rotor held, and for the
/// contact mode, a rotor with its load against the inductive stiffness K_L (4) of a winding with a
/// constant set-point.
[[nodiscard]] Experiments integrator_experiments(const loops::StabilityCase &which);

/// A penalty method, which uses the closest point of a mesh, and the proxy: thin walls, fast tips,
/// edges and corners, cracks, degenerate triangles, and tips that start inside.
[[nodiscard]] Experiments contact_experiments();

/// The servo's own loop at 1 kHz, on simulated devices: missed ticks, jitter, a late or lost
/// device, a hung window, a change of scene, and a hand that releases while it presses.
[[nodiscard]] Experiments servo_experiments(const loops::StabilityCase &which);

/// Limits of the amplifier.
[[nodiscard]] Experiments amplifier_experiments(const device::DeviceDescription &device);
/// Where the servo's last stage limits e_W before the motor's or the device's limits are reached.
[[nodiscard]] Experiments limiter_experiments(const loops::StabilityCase &which);
/// Limits of winding temperature, and the effect of warming on a held contact.
[[nodiscard]] Experiments heat_experiments(const device::DeviceDescription &device);

} // namespace springdrive::limits
