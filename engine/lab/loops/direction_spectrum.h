// The angle between force and surface normal when the tip vibrates against the surface: "the
// stiffness shape compensation does not have infinite bandwidth" (section V of the paper), as a
// function of frequency (figure 7, beyond the paper). In the plane of the links, base locked.
//
// Under the inverse map each motor has the stiffness K_θ at every frequency. Under the transpose
// map the sampled law with a locked set-point x₀ = 0, x = J θ, is, with A = α W⁻¹ JᵀJ and v = D θ
// the filtered velocity,
//
//   e_W = k_T (I − A) v − K_D A v − K_P A θ
//   −τ/θ = k_T/(jωL + dR) [ k_T jω I − k_T D H (I − A) + (K_P + K_D D) H A ]
//
// with D = (1 − a)(1 − z⁻¹)/(T (1 − a z⁻¹)) and H the hold with its delay, as in docs/design.md,
// "Sampled forms". This is affine in A, so it is K_θ of the contact on the share A and K_θ of free
// space on the rest:
//
//   −τ/θ = K_contact A + K_free (I − A)       K_free: K_θ with K_P = 0 and K_D = −k_T
//
// At low frequencies K_free = 0 and only the sphere (27) remains; far above λ both are K_L, the
// ellipsoid (21).
#pragma once

#include "device/core/device_description.h"
#include "engine/lab/loops/rendered_stiffness.h"
#include "engine/lab/loops/stiffness_ellipse.h"

#include <Eigen/Core>

#include <array>

namespace springdrive::loops {

/// A planar device in contact, with its drives and the map's α and W.
struct PlanarContact {
    Matrix2 J;                            ///< see `planar_jacobian`
    double alpha_rad2_per_m2 = 0.0;       ///< α of (23)
    Vector2 relative_stiffness{1.0, 1.0}; ///< W, see engine/control/motion_control.h
    std::array<SpringDrive, 2> drive;     ///< of the motors of q₂ and q₃; one servo, one tuning
};

/// A device's, at a configuration under one tuning.
[[nodiscard]] PlanarContact planar_contact(const device::DeviceDescription &device,
                                           const control::Tuning &tuning, const Vector3 &q_rad,
                                           double alpha_rad2_per_m2, const Sampling &sampling);

/// −τ/θ of both motors [N·m/rad] at a locked set-point of the tip.
[[nodiscard]] Eigen::Matrix2cd motor_stiffness(const PlanarContact &contact, control::MotionMap map,
                                               double omega_rad_per_s);

/// The tip's stiffness J⁻ᵀ (−τ/θ) J⁻¹ [N/m], (22).
[[nodiscard]] Eigen::Matrix2cd tip_stiffness(const PlanarContact &contact, control::MotionMap map,
                                             double omega_rad_per_s);

/// The angle between a vibrating force, given by its phasor, and a normal: arccos(|nᴴF|/‖F‖), 0 to
/// π/2, whatever the phase between force and motion. Where both components of F have one phase it
/// is the angle between two lines; otherwise the force runs around an ellipse, and the angle gives
/// the share of its amplitude that is not along n.
[[nodiscard]] double phasor_direction_error_rad(const Eigen::Vector2cd &force,
                                                const Vector2 &normal);

/// The largest such angle over normals in all directions, 1/4 degree apart [rad].
[[nodiscard]] double worst_direction_error_rad(const Eigen::Matrix2cd &tip_stiffness);

} // namespace springdrive::loops
