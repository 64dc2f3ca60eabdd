#include "engine/lab/loops/rendered_stiffness.h"

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

} // namespace springdrive::loops
