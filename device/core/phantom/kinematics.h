// The PHANTOM's parallel linkage (docs/design.md, "Linkage and motors"): its dimensions and masses,
// its kinematics and its motor-space Jacobian.
//
// All angles zero: upper arm level towards the user, forearm hanging down. q₂ and q₃ are both
// measured from the base, so the links are perpendicular at q₂ = q₃, and aligned, which is
// singular, at q₂ − q₃ = ±90°. The base joint is singular where the reach r is zero.
//
//   r = l₁ cos q₂ + l₂ sin q₃
//   x = r sin q₁      y = l₂ − l₂ cos q₃ + l₁ sin q₂      z = r cos q₁ − l₁
//
// Pure functions over values. RT-safe: no allocation, lock, I/O or throw.
#pragma once

#include "base/degrees.h"
#include "base/vector.h"

#include <array>
#include <optional>

namespace springdrive::device {

/// Link lengths and transmission; θ = N q, N diagonal. The values come from a device file.
struct PhantomGeometry {
    double upper_arm_m = 0.0;                    ///< l₁
    double forearm_m = 0.0;                      ///< l₂
    double crank_m = 0.0;                        ///< l₃, whose rod turns the forearm
    Vector3 transmission_ratio{Vector3::Ones()}; ///< diagonal of N, motor turns per joint turn
};

/// One moving part of the linkage. It turns with q₂ (upper arm, rod) or with q₃ (crank, forearm),
/// and with the whole linkage about the vertical axis.
struct LinkBody {
    double mass_kg = 0.0;
    double centre_m = 0.0; ///< centre of mass along the link, from the joint that it turns about
    /// Normal to the linkage's plane, across the link in that plane, along the link; about the
    /// joint for upper arm and crank, about the centre of mass for rod and forearm.
    Vector3 inertia_kg_m2{Vector3::Zero()};
};

/// The four links that move in the plane, including the motors that they carry.
struct LinkageInertia {
    double base_kg_m2 = 0.0;  ///< of all parts that turn with q₁ alone, about the vertical axis
    LinkBody upper_arm;       ///< l₁ from the base joint, with the third joint's motor behind it
    LinkBody crank;           ///< l₃ from the base joint, with the second joint's motor behind it
    LinkBody rod;             ///< from the crank's end to the forearm, parallel to the upper arm
    LinkBody forearm;         ///< l₂ from the elbow to the tip
    double tip_load_kg = 0.0; ///< thimble, stylus or sensor, a point mass at the tip
};

/// The configuration of figures and predictions where no other is asked for, q₁ to q₃: the tip in
/// front of the user, all three joints away from where the device is singular.
inline constexpr std::array<double, 3> kDefaultPose_deg{0.0, 20.0, -15.0};
[[nodiscard]] inline Vector3 default_pose_rad() {
    return {kDefaultPose_deg[0] * kRadiansPerDegree, kDefaultPose_deg[1] * kRadiansPerDegree,
            kDefaultPose_deg[2] * kRadiansPerDegree};
}

/// Tip position x = fk(q) [m] at joint angles q [rad], device frame.
[[nodiscard]] Vector3 tip_position_m(const PhantomGeometry &geometry, const Vector3 &q_rad);

/// ∂x/∂q [m/rad], one column per joint.
[[nodiscard]] Matrix3 joint_jacobian(const PhantomGeometry &geometry, const Vector3 &q_rad);

/// Tip position and joint Jacobian at one configuration.
struct TipPlace {
    Vector3 tip_m{Vector3::Zero()};
    Matrix3 jacobian_m_per_rad{Matrix3::Zero()};
};
[[nodiscard]] TipPlace tip_place(const PhantomGeometry &geometry, const Vector3 &q_rad);

/// J = ∂x/∂θ = (∂x/∂q) N⁻¹ [m/rad], one column per motor: J of docs/design.md, "Symbols".
[[nodiscard]] Matrix3 motor_jacobian(const PhantomGeometry &geometry, const Vector3 &q_rad);

/// d/dt of `joint_jacobian` [m/(rad·s)] while the joints turn at `q_rate_rad_per_s`.
[[nodiscard]] Matrix3 joint_jacobian_rate(const PhantomGeometry &geometry, const Vector3 &q_rad,
                                          const Vector3 &q_rate_rad_per_s);

/// q = invkin(x) of (18) on the branch of the zero pose: r ≥ 0 and |q₂ − q₃| ≤ 90° [rad].
/// Empty if `tip_m` is out of reach or not finite. On the base axis, r = 0, where q₁ is free,
/// it is 0.
[[nodiscard]] std::optional<Vector3> joint_angles_rad(const PhantomGeometry &geometry,
                                                      const Vector3 &tip_m);

[[nodiscard]] inline Vector3 joint_from_motor(const PhantomGeometry &geometry,
                                              const Vector3 &theta_rad) {
    return theta_rad.cwiseQuotient(geometry.transmission_ratio);
}
[[nodiscard]] inline Vector3 motor_from_joint(const PhantomGeometry &geometry,
                                              const Vector3 &q_rad) {
    return q_rad.cwiseProduct(geometry.transmission_ratio);
}

/// The positions of the linkage's joints, for drawing [m, device frame]. The rod is parallel to the
/// upper arm.
struct LinkagePose {
    Vector3 base_m;     ///< the motors' axis, l₁ behind and l₂ above the zero pose's tip
    Vector3 elbow_m;    ///< end of the upper arm
    Vector3 tip_m;      ///< end of the forearm
    Vector3 crank_m;    ///< end of the crank that q₃ turns about the base
    Vector3 coupling_m; ///< joint of rod and forearm
};

[[nodiscard]] LinkagePose linkage_pose(const PhantomGeometry &geometry, const Vector3 &q_rad);

} // namespace springdrive::device
