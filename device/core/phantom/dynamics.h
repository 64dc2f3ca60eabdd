// Rigid-body dynamics of the PHANTOM's linkage after Çavuşoğlu, Feygin and Tendick 2002, in joint
// coordinates:
//
//   M(q) q̈ + C(q, q̇) q̇ + g(q) = τ
//
// Every link turns with q₂ or q₃ and the whole plane with q₁, so that a centre of mass lies at
//
//   r = a cos q₂ + b sin q₃  from the axis,      h = a sin q₂ − b cos q₃  above the base joint
//
// with two lengths a, b per link. The equations need only the sums of m a², m a b, m b², m a, m b
// over all links (`LinkageMoments`). A load at the tip is a further link with a = l₁, b = l₂.
//
// Pure functions over values. RT-safe: no allocation, lock, I/O or throw.
#pragma once

#include "base/vector.h"
#include "device/core/phantom/geometry.h"

namespace springdrive::device {

inline constexpr double kGravity_m_per_s2 = 9.80665;

/// The sums over all links that the equations of motion need; symbols as at the top of this file.
struct LinkageMoments {
    double maa_kg_m2 = 0.0; ///< Σ m a²
    double mab_kg_m2 = 0.0; ///< Σ m a b
    double mbb_kg_m2 = 0.0; ///< Σ m b²
    double ma_kg_m = 0.0;   ///< Σ m a, for gravity
    double mb_kg_m = 0.0;   ///< Σ m b, for gravity
    double base_kg_m2 = 0.0;
    Vector3 with_q2_kg_m2{Vector3::Zero()}; ///< inertia of links that turn with q₂, as in LinkBody
    Vector3 with_q3_kg_m2{Vector3::Zero()}; ///< the same with q₃
};

/// @param tip_load_kg  at the tip, instead of `inertia.tip_load_kg`
[[nodiscard]] LinkageMoments linkage_moments(const PhantomGeometry &geometry,
                                             const LinkageInertia &inertia, double tip_load_kg);

/// Orientation of the links in their plane.
struct LinkSines {
    double sin_q2 = 0.0;
    double cos_q2 = 1.0;
    double sin_q3 = 0.0;
    double cos_q3 = 1.0;

    [[nodiscard]] static LinkSines of(const Vector3 &q_rad);

    /// sin(q₃ − q₂).
    [[nodiscard]] double sin_fold() const { return sin_q3 * cos_q2 - cos_q3 * sin_q2; }
};

/// M(q) [kg·m²], symmetric and positive definite. Without the rotors.
[[nodiscard]] Matrix3 mass_matrix(const LinkageMoments &moments, const LinkSines &links);
[[nodiscard]] inline Matrix3 mass_matrix(const LinkageMoments &moments, const Vector3 &q_rad) {
    return mass_matrix(moments, LinkSines::of(q_rad));
}

/// The part of M(q) that belongs to joints 2 and 3.
[[nodiscard]] Eigen::Matrix2d mass_matrix_of_plane(const LinkageMoments &moments,
                                                   const LinkSines &links);

/// C(q, q̇) q̇ [N·m]: Coriolis and centrifugal torques.
[[nodiscard]] Vector3 coriolis_torque_Nm(const LinkageMoments &moments, const Vector3 &q_rad,
                                         const Vector3 &q_rate_rad_per_s);

/// g(q) [N·m]: the torques that balance gravity, the gradient of `gravity_energy_J`.
[[nodiscard]] Vector3 gravity_torque_Nm(const LinkageMoments &moments, const Vector3 &q_rad);

/// Relative to the linkage with level upper arm and level forearm.
[[nodiscard]] double gravity_energy_J(const LinkageMoments &moments, const Vector3 &q_rad);

// Secants: difference quotients between two configurations a step apart, so that energy is balanced
// exactly over that step. Each equals the derivative if the two coincide, and is accurate to second
// order about their midpoint.

/// J̄ [m/rad] with J̄ (q_b − q_a) = fk(q_b) − fk(q_a).
[[nodiscard]] Matrix3 tip_secant(const PhantomGeometry &geometry, const Vector3 &q_a,
                                 const Vector3 &q_b);

/// Γ [kg·m²/s] with (q_b − q_a)ᵀ Γ v = ½ uᵀ (M(q_b) − M(q_a)) v for every v; u = `rate_rad_per_s`.
[[nodiscard]] Matrix3 inertia_secant(const LinkageMoments &moments, const Vector3 &q_a,
                                     const Vector3 &q_b, const Vector3 &rate_rad_per_s);

/// ḡ [N·m] with ḡᵀ (q_b − q_a) = the difference in `gravity_energy_J`.
[[nodiscard]] Vector3 gravity_secant_Nm(const LinkageMoments &moments, const Vector3 &q_a,
                                        const Vector3 &q_b);

} // namespace springdrive::device
