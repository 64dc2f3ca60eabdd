// From a contact constraint to motor voltages: equations (10), (18), (23), (24), (29), (30).
//
// Everything is done in motor coordinates, J = ∂x/∂θ (docs/design.md, "Contact and maps"). Motors
// may differ: with K_q diagonal and k̄ its mean, W = K_q/k̄ below is their stiffness relative to one
// another, and (23), (24) and (29) become
//
//   θ_Sd = θ + α W⁻¹ Jᵀ (x_Sd − x)         K_x = α k̄ I         α ≤ λ_min(J⁻ᵀ W J⁻¹)
//
// Pure functions over values. RT-safe: no allocation, lock, I/O or throw.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"
#include "engine/contact/contact.h"
#include "engine/control/tuning.h"

#include <optional>

namespace springdrive::control {

/// The set-point of the coupling K_θ, in tip space.
struct TipSetPoint {
    Vector3 x_Sd_m{Vector3::Zero()};
    Vector3 x_Sd_rate_m_per_s{Vector3::Zero()};
};

/// The same in motor space.
struct MotorSetPoint {
    Vector3 theta_Sd_rad{Vector3::Zero()};
    Vector3 theta_Sd_rate_rad_per_s{Vector3::Zero()};
};

/// The present configuration, as far as the maps depend on it.
struct Configuration {
    Vector3 theta_rad{Vector3::Zero()};
    Vector3 theta_rate_rad_per_s{Vector3::Zero()}; ///< θ̇_f, filtered
    Vector3 tip_m{Vector3::Zero()};                ///< x = fk(q)
    Matrix3 J{Matrix3::Identity()};                ///< ∂x/∂θ [m/rad]

    [[nodiscard]] Vector3 tip_velocity_m_per_s() const { return J * theta_rate_rad_per_s; }
};

/// Motion control (30) with a constraint that slides:
///
///   x_Sd = η x + (1 − η) x₀        ẋ_Sd = η ẋ + (1 − η) P ẋ
///
/// This differs from the paper, which holds x₀ fixed (P = 0): with that, a frictionless surface
/// would drag (docs/design.md, "Contact and maps"). `eta` is that of surface and tuning together,
/// see `combined_eta`.
[[nodiscard]] TipSetPoint contact_set_point(const Vector3 &tip_m,
                                            const Vector3 &tip_velocity_m_per_s,
                                            const contact::Contact &contact, double eta);

/// η of a surface under a tuning: their stiffness fractions 1 − η multiply.
[[nodiscard]] inline double combined_eta(double surface_eta, double tuning_eta) {
    return 1.0 - (1.0 - surface_eta) * (1.0 - tuning_eta);
}

/// Inverse map (18): θ_Sd = N invkin(x_Sd), θ̇_Sd = J⁻¹ ẋ_Sd. Nothing where x_Sd is out of reach or
/// J is singular; use `no_force` then.
[[nodiscard]] std::optional<MotorSetPoint> inverse_map(const device::PhantomGeometry &geometry,
                                                       const Configuration &configuration,
                                                       const TipSetPoint &target);

/// The set-point of free space (16), which follows the device: no force results.
[[nodiscard]] inline MotorSetPoint no_force(const Configuration &configuration) {
    return {configuration.theta_rad, configuration.theta_rate_rad_per_s};
}

/// Transpose map (23), (24) with the relative stiffness W above [diagonal, mean 1].
[[nodiscard]] MotorSetPoint transpose_map(const Configuration &configuration,
                                          const TipSetPoint &target, double alpha_rad2_per_m2,
                                          const Vector3 &relative_stiffness);

/// The bound (29) on α at one configuration: λ_min(J⁻ᵀ W J⁻¹) = 1/λ_max(J W⁻¹ Jᵀ) [rad²/m²].
[[nodiscard]] double alpha_bound(const Matrix3 &J, const Vector3 &relative_stiffness);

/// The minimum of (29) over a grid of `points_per_axis`³ points of the workspace box that the tip
/// can reach [rad²/m²]. Takes milliseconds: not for the servo thread.
[[nodiscard]] double global_alpha_bound(const device::DeviceDescription &device,
                                        int points_per_axis = 15);

/// Drift compensation (10) for three motors with torque constants k_T:
///
///   e_W = k_T θ̇_Sd + K_D (θ̇_Sd − θ̇_f) + K_P (θ_Sd − θ)      [V]
///
/// @param gain  of each motor, by which its K_D and K_P are multiplied
[[nodiscard]] Vector3 drift_compensation_V(const Vector3 &k_T, const Tuning &tuning,
                                           const Configuration &configuration,
                                           const MotorSetPoint &set_point,
                                           const Vector3 &gain = Vector3::Ones());

/// k_T of the three motors [N·m/A].
[[nodiscard]] Vector3 torque_constants(const device::DeviceDescription &device);

/// W: each motor's K_θ (12) at low frequency relative to the mean of all. With the same dR, K_P and
/// K_D on every motor it is proportional to k_T (13).
[[nodiscard]] Vector3 relative_stiffness(const device::DeviceDescription &device);

} // namespace springdrive::control
