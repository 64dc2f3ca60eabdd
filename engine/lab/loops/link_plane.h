// The tip's stiffness in the plane of the links, for a device whose base joint is locked as in the
// paper's section VI: at rest, the ellipse of the inverse map and the circle of the transpose map
// (Fig. 3, and the directions of Figs. 5 and 6); and over frequency, the direction of the force
// (figure 7 of `springdrive figures`, which the paper does not have).
//
// The plane's axes are outward (horizontal, from the base joint's axis towards the tip) and up. Its
// motors are those of q₂ and q₃.
#pragma once

#include "device/core/device_description.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/tuning.h"
#include "engine/lab/loops/rendered_stiffness.h"

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <vector>

namespace springdrive::loops {

using Vector2 = Eigen::Vector2d;
using Matrix2 = Eigen::Matrix2d;

/// The axes of the plane, outward and up, as columns in the device frame.
[[nodiscard]] inline Eigen::Matrix<double, 3, 2> link_plane(double q1_rad) {
    Eigen::Matrix<double, 3, 2> axes;
    axes << std::sin(q1_rad), 0.0, //
        0.0, 1.0,                  //
        std::cos(q1_rad), 0.0;
    return axes;
}

/// J = ∂x/∂θ within the plane [m/rad]: rows outward and up, columns the motors of q₂ and q₃.
[[nodiscard]] inline Matrix2 planar_jacobian(const device::PhantomGeometry &geometry,
                                             const Vector3 &q_rad) {
    return link_plane(q_rad[0]).transpose() *
           device::motor_jacobian(geometry, q_rad).rightCols<2>();
}

/// The direction at an angle, counter-clockwise from outward to up.
[[nodiscard]] inline Vector2 direction_at(double angle_rad) {
    return {std::cos(angle_rad), std::sin(angle_rad)};
}

/// The angle from `from` to `to`, counter-clockwise, −π to π.
[[nodiscard]] inline double signed_angle_rad(const Vector2 &from, const Vector2 &to) {
    return std::atan2(from.x() * to.y() - from.y() * to.x(), from.dot(to));
}

/// The stiffnesses of both maps for a device whose base is locked [N/m]: force per displacement.
struct PlanarStiffness {
    Matrix2 inverse;   ///< J⁻ᵀ K_q J⁻¹ (21); the motors' K_q may differ
    Matrix2 transpose; ///< α (1 − η) k̄ I (27); k̄: the mean K_DC of all three motors
    double alpha_rad2_per_m2 = 0.0;   ///< the bound (29) of the planar device
    Vector2 K_q_Nm_per_rad{0.0, 0.0}; ///< (1 − η) K_DC, (20), of the motors of q₂ and q₃
};

/// At rest: K_q = (1 − η) K_DC of each motor (13), and α as large as (29) allows.
/// @throw InputError where the links are aligned, or where the tuning has no static stiffness.
[[nodiscard]] PlanarStiffness planar_stiffness(const device::DeviceDescription &device,
                                               const control::Tuning &tuning, const Vector3 &q_rad);

/// A displacement's direction and the forces that result.
struct EllipsePoint {
    double angle_rad = 0.0;              ///< direction of the displacement
    Vector2 inverse_N_per_m{0.0, 0.0};   ///< force of the inverse map, per displacement
    Vector2 transpose_N_per_m{0.0, 0.0}; ///< force of the transpose map, per displacement
};

/// One full turn: K n for `points` unit vectors n, and the first once more. The semi-axes are the
/// eigenvalues of K.
[[nodiscard]] std::vector<EllipsePoint> stiffness_ellipses(const PlanarStiffness &stiffness,
                                                           int points);

/// The angle from a normal to the inverse map's force, for a small penetration along that normal.
/// @param normal_rad  direction of the normal, as for `direction_at`
[[nodiscard]] double inverse_direction_error_rad(const PlanarStiffness &stiffness,
                                                 double normal_rad);

// The angle between force and surface normal when the tip vibrates against the surface, as a
// function of frequency: the shape compensation "does not have infinite bandwidth" (section V).
//
// Under the inverse map each motor has the stiffness K_θ at every frequency. Under the transpose
// map the sampled law (10), (23), (24) with a locked set-point x_Sd = 0, x = J θ, is, with
// A = α W⁻¹ JᵀJ and v = D θ the filtered velocity,
//
//   e_W = k_T (I − A) v − K_D A v − K_P A θ
//   −τ/θ = k_T/(jωL + dR) [ k_T jω I − k_T D H (I − A) + (K_P + K_D D) H A ]
//
// by (11), with D = (1 − a)(1 − z⁻¹)/(T (1 − a z⁻¹)) and H the hold with its delay, docs/design.md,
// "Sampled forms". This is affine in A, so it is K_θ of the contact on the share A and K_θ of free
// space on the rest:
//
//   −τ/θ = K_contact A + K_free (I − A)       K_free: K_θ with K_P = 0 and K_D = −k_T
//
// At low frequencies K_free = 0 and only the sphere (27) remains; far above λ both are K_L, the
// ellipsoid (21).

/// A planar device in contact, with its drives and the map's α and W.
struct PlanarContact {
    Matrix2 J;                            ///< see `planar_jacobian`
    double alpha_rad2_per_m2 = 0.0;       ///< α of (23)
    Vector2 relative_stiffness{1.0, 1.0}; ///< W, see engine/control/motion_control.h
    std::array<SpringDrive, 2> drive; ///< for q₂ and q₃; they share one servo and one tuning
};

/// The contact of a device at a configuration.
[[nodiscard]] PlanarContact planar_contact(const device::DeviceDescription &device,
                                           const control::Tuning &tuning, const Vector3 &q_rad,
                                           double alpha_rad2_per_m2, const Sampling &sampling);

/// −τ/θ of both motors [N·m/rad] with the tip's set-point locked.
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

/// The largest such angle [rad] over normals in all directions, 1/4 degree apart.
[[nodiscard]] double worst_direction_error_rad(const Eigen::Matrix2cd &tip_stiffness);

} // namespace springdrive::loops
