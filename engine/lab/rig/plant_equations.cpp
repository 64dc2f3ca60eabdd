#include "engine/lab/rig/plant_equations.h"

#include "device/core/phantom/kinematics.h"

#include <Eigen/LU>

#include <cmath>
#include <cstddef>

namespace springdrive::rig {

Vector3 PlantInertia::acceleration(const Vector3 &torque_Nm) const {
    const double determinant = two_kg_m2 * three_kg_m2 - coupling_kg_m2 * coupling_kg_m2;
    return {torque_Nm[0] / axial_kg_m2,
            (three_kg_m2 * torque_Nm[1] - coupling_kg_m2 * torque_Nm[2]) / determinant,
            (two_kg_m2 * torque_Nm[2] - coupling_kg_m2 * torque_Nm[1]) / determinant};
}

Matrix3 PlantInertia::matrix_kg_m2() const {
    Matrix3 M;
    M << axial_kg_m2, 0.0, 0.0,         //
        0.0, two_kg_m2, coupling_kg_m2, //
        0.0, coupling_kg_m2, three_kg_m2;
    return M;
}

PlantEquations::PlantEquations(const device::DeviceDescription &device,
                               const simulated::SimulationOptions &options)
    : geometry_(device.geometry), hand_(options.hand),
      moments_(device::linkage_moments(device.geometry, device.inertia,
                                       device.inertia.tip_load_kg + options.hand.mass_kg)),
      gravity_m_per_s2_(options.effects.gravity ? device::kGravity_m_per_s2 : 0.0),
      viscous_Nms_per_rad_(options.effects.viscous_friction ? device.friction.viscous_Nms_per_rad
                                                            : 0.0) {
    moments_.ma_kg_m -= hand_.mass_kg * geometry_.upper_arm_m;
    moments_.mb_kg_m -= hand_.mass_kg * geometry_.forearm_m;
    if (options.effects.coulomb_friction) {
        coulomb_Nm_ = device.friction.coulomb_Nm;
        has_coulomb_ = true;
    }
    for (Eigen::Index j = 0; j < 3; ++j) {
        const device::MotorParameters &motor = device.motor[static_cast<std::size_t>(j)];
        const double N = geometry_.transmission_ratio[j];
        rotor_kg_m2_[j] = N * N * motor.rotor_inertia_kg_m2;
        torque_Nm_per_A_[j] = N * motor.torque_constant_Nm_per_A;
        resistance_Ohm_[j] = motor.resistance_Ohm;
        inductance_H_[j] = motor.inductance_H;
    }
}

void PlantEquations::set_inputs(const PlantInputs &inputs) { inputs_ = inputs; }

void PlantEquations::set_friction_width(double width_rad_per_s) {
    friction_width_rad_per_s_ = width_rad_per_s;
}

PlantState PlantEquations::rates(double time_s, const PlantState &y) const {
    PlantState rate = position_rates(y);
    rate.segment<3>(3) = acceleration(time_s, y);
    return rate;
}

PlantState PlantEquations::momentum_rates(double time_s, const PlantState &y) const {
    PlantState rate = PlantState::Zero();
    rate.segment<3>(3) = acceleration(time_s, y);
    return rate;
}

PlantState PlantEquations::position_rates(const PlantState &y) const {
    const Vector3 dR_Ohm = resistance_Ohm_ - inputs_.command.cancelled_resistance_Ohm;
    PlantState rate = PlantState::Zero();
    rate.head<3>() = y.segment<3>(3);
    rate.tail<3>() = (inputs_.command.e_W_V - dR_Ohm.cwiseProduct(y.tail<3>()) -
                      torque_Nm_per_A_.cwiseProduct(y.segment<3>(3)))
                         .cwiseQuotient(inductance_H_);
    return rate;
}

Vector3 PlantEquations::tip_force_N(const PlantState &y) const {
    const Matrix3 J = device::joint_jacobian(geometry_, y.head<3>());
    return J.transpose().inverse() * torque_Nm_per_A_.cwiseProduct(y.tail<3>());
}

Vector3 PlantEquations::acceleration(double time_s, const PlantState &y) const {
    PlantMechanics now = mechanics(time_s, y);
    if (has_coulomb_) {
        now.torque_Nm -= friction_Nm(y.segment<3>(3));
    }
    return now.inertia.acceleration(now.torque_Nm);
}

Vector3 PlantEquations::friction_Nm(const Vector3 &rate_rad_per_s) const {
    const auto direction = [this](double rate) {
        return friction_width_rad_per_s_ > 0.0 ? std::tanh(rate / friction_width_rad_per_s_)
                                               : static_cast<double>((rate > 0.0) - (rate < 0.0));
    };
    return coulomb_Nm_.cwiseProduct(rate_rad_per_s.unaryExpr(direction));
}

PlantMechanics PlantEquations::mechanics(double time_s, const PlantState &y) const {
    const device::LinkageMoments &m = moments_;
    const double l1 = geometry_.upper_arm_m;
    const double l2 = geometry_.forearm_m;
    const double s1 = std::sin(y[0]);
    const double c1 = std::cos(y[0]);
    const double s2 = std::sin(y[1]);
    const double c2 = std::cos(y[1]);
    const double s3 = std::sin(y[2]);
    const double c3 = std::cos(y[2]);
    const double sin_fold = s3 * c2 - c3 * s2;
    const double cos_fold = c3 * c2 + s3 * s2;
    const Vector3 w = y.segment<3>(3);

    const double r = l1 * c2 + l2 * s3;
    Matrix3 J;
    J << r * c1, -l1 * s1 * s2, l2 * s1 * c3, //
        0.0, l1 * c2, l2 * s3,                //
        -r * s1, -l1 * c1 * s2, l2 * c1 * c3;
    const Vector3 tip_m(r * s1, l2 - l2 * c3 + l1 * s2, r * c1 - l1);
    const Vector3 target_m =
        inputs_.target.position_m + (time_s - inputs_.start_s) * inputs_.target.velocity_m_per_s;
    const Vector3 hand_N = hand_.stiffness_N_per_m * (target_m - tip_m) +
                           hand_.damping_Ns_per_m * (inputs_.target.velocity_m_per_s - J * w);

    const double with_q2 = m.maa_kg_m2 + m.with_q2_kg_m2[1];
    const double with_q3 = m.mbb_kg_m2 + m.with_q3_kg_m2[1];
    PlantMechanics sum;
    PlantInertia &M = sum.inertia;
    M.axial_kg_m2 = m.base_kg_m2 + with_q2 * c2 * c2 + m.with_q2_kg_m2[2] * s2 * s2 +
                    with_q3 * s3 * s3 + m.with_q3_kg_m2[2] * c3 * c3 + 2.0 * m.mab_kg_m2 * c2 * s3 +
                    rotor_kg_m2_[0];
    M.two_kg_m2 = m.maa_kg_m2 + m.with_q2_kg_m2[0] + rotor_kg_m2_[1];
    M.three_kg_m2 = m.mbb_kg_m2 + m.with_q3_kg_m2[0] + rotor_kg_m2_[2];
    M.coupling_kg_m2 = m.mab_kg_m2 * sin_fold;

    // ½ ∂M₁₁/∂q₂, ½ ∂M₁₁/∂q₃ and ∂M₂₃/∂q₃.
    const double by_q2 = -(with_q2 - m.with_q2_kg_m2[2]) * c2 * s2 - m.mab_kg_m2 * s2 * s3;
    const double by_q3 = (with_q3 - m.with_q3_kg_m2[2]) * s3 * c3 + m.mab_kg_m2 * c2 * c3;
    const double fold_by_q3 = m.mab_kg_m2 * cos_fold;
    const Vector3 coriolis_Nm(2.0 * w[0] * (by_q2 * w[1] + by_q3 * w[2]),
                              fold_by_q3 * w[2] * w[2] - by_q2 * w[0] * w[0],
                              -fold_by_q3 * w[1] * w[1] - by_q3 * w[0] * w[0]);
    const Vector3 weight_Nm(0.0, gravity_m_per_s2_ * m.ma_kg_m * c2,
                            gravity_m_per_s2_ * m.mb_kg_m * s3);
    sum.torque_Nm = torque_Nm_per_A_.cwiseProduct(y.tail<3>()) + J.transpose() * hand_N -
                    coriolis_Nm - weight_Nm - viscous_Nms_per_rad_ * w;
    return sum;
}

} // namespace springdrive::rig
