#include "engine/lab/loops/rendered_stiffness.h"

#include "engine/control/velocity_filter.h"

#include <cmath>

namespace springdrive::loops {

namespace {

using Complex = std::complex<double>;

/// 1 − e^(−jx) without the cancellation at small x.
Complex one_minus_turn(double x) {
    const double half = std::sin(0.5 * x);
    return {2.0 * half * half, std::sin(x)};
}

/// H(jω): what holding a sample for T, d periods late, makes of it.
Complex hold(double omega_rad_per_s, double period_s, double delay_periods) {
    const double x = omega_rad_per_s * period_s;
    if (x == 0.0) {
        return 1.0;
    }
    return std::polar(1.0, -x * delay_periods) * one_minus_turn(x) / Complex(0.0, x);
}

/// C(e^(jωT)): K_P, and K_D on the filtered difference.
Complex drift_compensation(const SpringDrive &drive, double omega_rad_per_s) {
    const double T = drive.period_s;
    const double a = control::velocity_filter_pole(drive.tuning.lambda_rad_per_s, T);
    const Complex difference = one_minus_turn(omega_rad_per_s * T);
    // 1 − a z⁻¹ = (1 − a) + a (1 − z⁻¹)
    const Complex rate = (1.0 - a) * difference / (T * (1.0 - a + a * difference));
    return drive.tuning.K_P_V_per_rad + drive.tuning.K_D_Vs_per_rad * rate;
}

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
    const Complex back_emf(0.0, drive.motor.torque_constant_Nm_per_A * omega_rad_per_s);
    return torque_per_volt(drive.motor, drive.dR_Ohm(), omega_rad_per_s) *
           (back_emf + drift_compensation(drive, omega_rad_per_s) *
                           hold(omega_rad_per_s, drive.period_s, drive.delay_periods));
}

std::complex<double> unmodified_stiffness(const device::MotorParameters &motor,
                                          double omega_rad_per_s) {
    return torque_per_volt(motor, motor.resistance_Ohm, omega_rad_per_s) *
           Complex(0.0, motor.torque_constant_Nm_per_A * omega_rad_per_s);
}

} // namespace springdrive::loops
