// One energy-exact step of the linkage with rotors, friction and stops.
//
// With p = M(q) q̇ and the secants of device/core/phantom/dynamics.h, from state a to state b:
//
//   q_b − q_a = h (q̇_a + q̇_b)/2
//   M_b q̇_b − M_a q̇_a = h [ Γ q̇_b − ḡ + τ − B (q̇_a + q̇_b)/2 + friction + stops + J̄ᵀ F ]
//
// Γ, the secant of ½ q̇_aᵀ M q̇_b, makes the change in kinetic energy equal to the work of the
// right-hand side to round-off, for any h; the scheme is symmetric and second order.
//
// Without masses the left-hand side is zero, and the mean rate balances the right-hand side. The
// rates at both ends of a step then equal its mean, as nothing stores them.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"
#include "device/core/phantom/dynamics.h"
#include "device/simulated/friction.h"

#include <array>

namespace springdrive::simulated {

/// The action of the stops at the ends of the joints' travel over a step, one-sided springs with
/// dampers. The springs act by the secant of their energy, so that the work
/// over the step is exact. A damper acts if its stop is already pressed at the start of the step,
/// so that this does not change while the step is solved.
struct StopTorque {
    Vector3 torque_Nm{Vector3::Zero()};           ///< of the springs
    Matrix3 damping_Nms_per_rad{Matrix3::Zero()}; ///< positive semidefinite
};

/// RT-safe.
[[nodiscard]] StopTorque stop_torque(const device::JointLimits &limits, const Vector3 &q_a_rad,
                                     const Vector3 &q_b_rad) noexcept;

/// Energy stored in the springs [J].
[[nodiscard]] double stop_energy_J(const device::JointLimits &limits,
                                   const Vector3 &q_rad) noexcept;

struct LinkageState {
    Vector3 q_rad{Vector3::Zero()};
    Vector3 rate_rad_per_s{Vector3::Zero()};
};

/// Parameters of the linkage, constant over all steps.
struct LinkagePlant {
    device::PhantomGeometry geometry;
    device::LinkageMoments moments;       ///< with everything rigidly attached to the tip
    Vector3 rotor_kg_m2{Vector3::Zero()}; ///< reflected to the joints, N² J_m
    Vector3 coulomb_Nm{Vector3::Zero()};
    device::JointLimits limits;
    bool gravity = true;
    bool stops = true;
    bool has_mass = true;              ///< false: `moments` are used for gravity only
    bool planar = false;               ///< the base is at rest and two joints move
    Vector3 outward{Vector3::UnitZ()}; ///< planar: horizontal direction in the links' plane

    [[nodiscard]] double kinetic_energy_J(const LinkageState &state) const;
    [[nodiscard]] double potential_energy_J(const LinkageState &state) const; ///< gravity and stops
};

/// The load on the linkage over a step, affine in the mean rates: τ − B q̄̇ at the joints and F − c
/// J̄ q̄̇ at the tip.
struct LinkageLoad {
    Vector3 torque_Nm{Vector3::Zero()};
    Vector3 damping_Nms_per_rad{Vector3::Zero()}; ///< the diagonal of B
    Vector3 tip_force_N{Vector3::Zero()};
    double tip_damping_Ns_per_m = 0.0;
};

/// The result of a step.
struct LinkageMotion {
    LinkageState after;
    Vector3 mean_rate_rad_per_s{Vector3::Zero()};
    Vector3 mean_tip_velocity_m_per_s{Vector3::Zero()}; ///< the tip's displacement over h
};

/// @param modes  of friction, kept from step to step
/// RT-safe: each iteration gains about three digits, and a step that does not converge in twelve is
/// divided into up to 64 smaller ones, which dissipate no less. If even those do not converge, at
/// hundreds of radians a second with kilogrammes at the tip, the linkage is brought to rest.
[[nodiscard]] LinkageMotion linkage_step(const LinkagePlant &plant, const LinkageState &before,
                                         const LinkageLoad &load, double step_s,
                                         std::array<FrictionMode, 3> &modes) noexcept;

} // namespace springdrive::simulated
