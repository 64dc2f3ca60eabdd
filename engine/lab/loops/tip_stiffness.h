// The stiffness that a sampled law renders at the tip over frequency, with either drive.
#pragma once

#include "engine/lab/loops/stability_case.h"

#include <complex>

namespace springdrive::loops {

/// The part along `direction` of the force against a tip that a vice moves along it at ω, per
/// displacement [N/m]; a spring has phase 0°, a damper +90°. All motors, at the case's
/// configuration and with its η:
///
///   K_x = J⁻ᵀ K_m J⁻¹
///
/// with K_m of `motor_stiffness`; for η = 0 and one motor that is K_θ.
[[nodiscard]] std::complex<double> tip_stiffness(const StabilityCase &which,
                                                 const Vector3 &direction, double omega_rad_per_s);

/// The limit as ω goes to infinity: the inductive stiffness (14) of a spring drive, zero for a
/// current drive [N/m].
[[nodiscard]] double inductive_tip_stiffness(const StabilityCase &which, const Vector3 &direction);

/// The change of the tip's force within a period from one count of one encoder, through gains,
/// filter and winding, all else at rest: the largest of the three encoders [N]. A large value is
/// felt as a buzz.
[[nodiscard]] double force_of_a_count_N(const StabilityCase &which);

} // namespace springdrive::loops
