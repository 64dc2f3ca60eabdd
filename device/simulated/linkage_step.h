// One step of the linkage with rotors, friction and stops, exact in energy.
//
// With p = M(q) q̇ and the secants of device/core/phantom/dynamics.h, from the state a to the state
// b:
//
//   q_b − q_a = h (q̇_a + q̇_b)/2
//   M_b q̇_b − M_a q̇_a = h [ Γ q̇_b − ḡ + τ − B (q̇_a + q̇_b)/2 + friction + stops + J̄ᵀ F ]
//
// Γ, the secant of ½ q̇_aᵀ M q̇_b, is what makes the kinetic energy's change equal the work of the
// right-hand side to round-off, whatever h; the scheme is symmetric and second order.
//
// Without masses the left-hand side is none, and the mean rate is what balances the right-hand
// side. The rates at the ends of a step are then its mean, as there is nothing to store them.
#pragma once

#include "device/core/phantom/dynamics.h"
#include "device/simulated/friction.h"
#include "device/simulated/joint_stops.h"

namespace springdrive::simulated {

struct LinkageState {
    Vector3 q_rad{Vector3::Zero()};
    Vector3 rate_rad_per_s{Vector3::Zero()};
};

/// What does not change from step to step.
struct LinkagePlant {
    device::PhantomGeometry geometry;
    device::LinkageMoments moments;       ///< with everything that sits rigidly at the tip
    Vector3 rotor_kg_m2{Vector3::Zero()}; ///< reflected to the joints, N² J_m
    Vector3 coulomb_Nm{Vector3::Zero()};
    device::JointLimits limits;
    bool gravity = true;
    bool stops = true;
    bool has_mass = true;              ///< false: `moments` serve gravity alone
    bool planar = false;               ///< the base stands still, which two joints show
    Vector3 outward{Vector3::UnitZ()}; ///< planar: along the links' plane, level

    [[nodiscard]] double kinetic_energy_J(const LinkageState &state) const;
    [[nodiscard]] double potential_energy_J(const LinkageState &state) const; ///< gravity and stops
};

/// What acts on the linkage over a step, affine in the mean rates: τ − B q̄̇ at the joints and
/// F − c J̄ q̄̇ at the tip.
struct LinkageLoad {
    Vector3 torque_Nm{Vector3::Zero()};
    Vector3 damping_Nms_per_rad{Vector3::Zero()}; ///< the diagonal of B
    Vector3 tip_force_N{Vector3::Zero()};
    double tip_damping_Ns_per_m = 0.0;
};

/// What a step brought about.
struct LinkageMotion {
    LinkageState after;
    Vector3 mean_rate_rad_per_s{Vector3::Zero()};
    Vector3 mean_tip_velocity_m_per_s{Vector3::Zero()}; ///< the tip's way over the step, over h
};

/// @param modes  of friction, kept from step to step
/// RT-safe: an iteration gains about three digits, and one that does not settle in twelve is taken
/// in smaller steps, 64 at most; they dissipate no less. What even those do not catch, motions at
/// hundreds of radians a second under kilogrammes, is brought to rest.
[[nodiscard]] LinkageMotion linkage_step(const LinkagePlant &plant, const LinkageState &before,
                                         const LinkageLoad &load, double step_s,
                                         std::array<FrictionMode, 3> &modes) noexcept;

} // namespace springdrive::simulated
