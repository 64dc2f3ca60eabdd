#include "engine/lab/loops/rendered_stiffness.h"

#include "device/core/phantom/kinematics.h"

#include <Eigen/LU>

namespace springdrive::loops {

namespace {

using Complex = std::complex<double>;

/// k_T/(jωL + R): torque per volt across the winding.
Complex torque_per_volt(const device::MotorParameters &motor, double resistance_Ohm,
                        double omega_rad_per_s) {
    return motor.torque_constant_Nm_per_A /
           Complex(resistance_Ohm, omega_rad_per_s * motor.inductance_H);
}

} // namespace

std::complex<double> analytic_stiffness(const SpringDrive &drive, double omega_rad_per_s) {
    const Complex s(0.0, omega_rad_per_s);
    const double k_T = drive.motor.torque_constant_Nm_per_A;
    const double K_P = drive.tuning.K_P_V_per_rad;
    const double K_D = drive.tuning.K_D_Vs_per_rad;
    const double lambda = drive.tuning.lambda_rad_per_s;
    return torque_per_volt(drive.motor, drive.dR_Ohm(), omega_rad_per_s) * lambda / (s + lambda) *
           ((k_T + K_D + K_P / lambda) * s + K_P + k_T * s * s / lambda);
}

std::complex<double> sampled_stiffness(const SpringDrive &drive, double omega_rad_per_s) {
    DrivenLoad load = DrivenLoad::of(1);
    load.put_behind_spring_drive(0, drive.motor, drive.dR_Ohm());
    const SampledLaw law =
        drift_compensation(load.torque_Nm_per_A, gains_of(drive.tuning),
                           Eigen::MatrixXd::Identity(1, 1), {drive.period_s, drive.delay_periods});
    return motor_stiffness(load, law, omega_rad_per_s)(0, 0);
}

std::complex<double> unmodified_stiffness(const device::MotorParameters &motor,
                                          double omega_rad_per_s) {
    return torque_per_volt(motor, motor.resistance_Ohm, omega_rad_per_s) *
           Complex(0.0, motor.torque_constant_Nm_per_A * omega_rad_per_s);
}

namespace {

StabilityCase whole(StabilityCase which) {
    which.freedom = Freedom::three_motors;
    return which;
}

} // namespace

Complex tip_stiffness(const StabilityCase &which, const Vector3 &direction,
                      double omega_rad_per_s) {
    const StabilityCase all = whole(which);
    const LoopMember without_hand{0, no_hand()};
    const DrivenLoad load = driven_load(all, without_hand);
    const SampledLaw law = sampled_law(all, without_hand);
    const Eigen::MatrixXcd motors = motor_stiffness(load, law, omega_rad_per_s);
    const Vector3 n = direction.normalized();
    const Vector3 theta = device::motor_jacobian(which.device.geometry, which.q_rad).inverse() * n;
    return theta.cast<Complex>().dot(motors * theta.cast<Complex>());
}

double inductive_tip_stiffness(const StabilityCase &which, const Vector3 &direction) {
    if (which.drive == device::AmplifierKind::current_drive) {
        return 0.0;
    }
    const Vector3 n = direction.normalized();
    const Vector3 theta = device::motor_jacobian(which.device.geometry, which.q_rad).inverse() * n;
    double stiffness = 0.0;
    for (Eigen::Index i = 0; i < 3; ++i) {
        stiffness +=
            theta[i] * theta[i] *
            device::inductive_stiffness_Nm_per_rad(which.device.motor[static_cast<std::size_t>(i)]);
    }
    return stiffness;
}

double force_of_a_count_N(const StabilityCase &which) {
    const StabilityCase all = whole(which);
    const LoopMember without_hand{0, no_hand()};
    const DrivenLoad load = driven_load(all, without_hand);
    const SampledLaw law = sampled_law(all, without_hand);
    const Matrix3 command =
        which.device.rad_per_count() *
        ((1.0 - law.filter_pole) / law.period_s * law.per_velocity + law.per_position);
    const Matrix3 current_A = sampled_load(load, which.period_s).block<3, 3>(6, 9) * command;
    const Matrix3 J = device::motor_jacobian(which.device.geometry, which.q_rad);
    const Matrix3 force_N = J.transpose().inverse() * load.torque_Nm_per_A.asDiagonal() * current_A;
    return force_N.colwise().norm().maxCoeff();
}

} // namespace springdrive::loops
