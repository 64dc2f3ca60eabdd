// Forces on the linkage between two configurations a step apart, for the joints that move. With
// two, the base is at rest and the tip moves in the links' plane: outward and up.
#pragma once

#include "device/core/phantom/linkage_secants.h"
#include "device/simulated/linkage_step.h"

namespace springdrive::simulated {

/// Torques on the joints, affine in their mean rates: τ − B q̄̇.
template <int joints> struct LinkageForces {
    device::JointMatrix<joints> tip_m_per_rad;       ///< J̄
    device::JointMatrix<joints> damping_Nms_per_rad; ///< B, positive semidefinite
    device::JointVector<joints> torque_Nm;
};

/// A vector at the tip, projected to the coordinates in which the tip can move. RT-safe.
template <int joints>
[[nodiscard]] device::JointVector<joints> where_tip_moves(const LinkagePlant &plant,
                                                          const Vector3 &v) {
    if constexpr (joints == 3) {
        return v;
    } else {
        return {plant.outward.dot(v), v.y()};
    }
}

/// The inverse: back to three dimensions. RT-safe.
template <int joints>
[[nodiscard]] Vector3 in_space(const LinkagePlant &plant, const device::JointVector<joints> &v) {
    if constexpr (joints == 3) {
        return v;
    } else {
        return v[0] * plant.outward + v[1] * Vector3::UnitY();
    }
}

/// RT-safe.
template <int joints>
[[nodiscard]] LinkageForces<joints> linkage_forces(const LinkagePlant &plant,
                                                   const LinkageLoad &load,
                                                   const device::LinkageSecants<joints> &secants,
                                                   const Vector3 &q_a, const Vector3 &q_b) {
    LinkageForces<joints> sum;
    sum.tip_m_per_rad = secants.tip(plant.geometry);
    const device::JointMatrix<joints> &J = sum.tip_m_per_rad;
    sum.damping_Nms_per_rad = load.tip_damping_Ns_per_m * (J.transpose() * J);
    sum.damping_Nms_per_rad.diagonal() += load.damping_Nms_per_rad.template tail<joints>();
    sum.torque_Nm = load.torque_Nm.template tail<joints>() +
                    J.transpose() * where_tip_moves<joints>(plant, load.tip_force_N);
    if (plant.gravity) {
        sum.torque_Nm -= secants.gravity_Nm(plant.moments);
    }
    if (plant.stops) {
        const StopTorque pressed = stop_torque(plant.limits, q_a, q_b);
        sum.torque_Nm += pressed.torque_Nm.template tail<joints>();
        sum.damping_Nms_per_rad +=
            pressed.damping_Nms_per_rad.template bottomRightCorner<joints, joints>();
    }
    return sum;
}

} // namespace springdrive::simulated
