// What both maps render in one state, whichever is in use: forces, stiffnesses, and how far the
// inverse map's force may turn away from the normal.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"
#include "engine/contact/contact.h"
#include "engine/control/motion_control.h"
#include "engine/control/tuning.h"

#include <optional>
#include <vector>

namespace springdrive::loops {

/// Static forces on the hand (19) [N].
struct MapForces {
    std::optional<Vector3> inverse_N; ///< where (18) has a solution
    Vector3 transpose_N{Vector3::Zero()};
};

/// By the law itself, with K_q = K_DC (13) of each motor; the contact's η counts.
[[nodiscard]] MapForces map_forces(const device::DeviceDescription &device,
                                   const control::Configuration &now,
                                   const contact::Contact &contact, const control::Tuning &tuning,
                                   double global_alpha_rad2_per_m2);

/// Force per displacement of the tip, as in Fig. 3 but in all three dimensions [N/m].
struct MapStiffness {
    Matrix3 inverse_N_per_m{Matrix3::Zero()}; ///< (21)
    double transpose_N_per_m = 0.0;           ///< (27): (1 − η) α k̄ in every direction
};

/// (21) at a configuration [N/m]: J⁻ᵀ K_q J⁻¹ with K_q = (1 − η) K_DC. @pre J is regular
[[nodiscard]] Matrix3 inverse_tip_stiffness(const device::DeviceDescription &device,
                                            const control::Tuning &tuning, const Vector3 &q_rad);

/// At rest, with the tuning's own η. Nothing where J is singular.
[[nodiscard]] std::optional<MapStiffness> map_stiffness(const device::DeviceDescription &device,
                                                        const control::Tuning &tuning,
                                                        const Vector3 &q_rad,
                                                        double alpha_rad2_per_m2);

/// The largest angle between a normal n and K n over all n, of a symmetric positive definite K:
///
///   sin φ = (λ_max − λ_min)/(λ_max + λ_min)        (Kantorovich's inequality)
///
/// NaN where K is not positive definite.
[[nodiscard]] double largest_error_rad(const Matrix3 &stiffness);

/// A place of the workspace with a quantity there.
struct WorkspaceValue {
    Vector3 tip_m{Vector3::Zero()};
    double value = 0.0;
};

/// The places of a grid over the workspace box that the tip can reach, where J is regular.
/// Takes milliseconds.
/// @param spacing_m  between neighbours along each axis
[[nodiscard]] std::vector<WorkspaceValue>
errors_in_workspace_rad(const device::DeviceDescription &device, const control::Tuning &tuning,
                        double spacing_m);
/// The transpose map's stiffness with α at the bound (29).
[[nodiscard]] std::vector<WorkspaceValue>
stiffnesses_in_workspace_N_per_m(const device::DeviceDescription &device,
                                 const control::Tuning &tuning, double spacing_m);

} // namespace springdrive::loops
