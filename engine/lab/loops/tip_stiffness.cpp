#include "engine/lab/loops/tip_stiffness.h"

#include "device/core/phantom/kinematics.h"

#include <Eigen/LU>

#include <cmath>

namespace springdrive::loops {

namespace {

using Complex = std::complex<double>;

StabilityCase whole(StabilityCase which) {
    which.freedom = Freedom::three_motors;
    return which;
}

/// e^(−jωdT) (1 − e^(−jωT))/(jωT), which is 1 at rest.
Complex hold(double omega, const SampledLaw &law) {
    const Complex x(0.0, omega * law.period_s);
    const Complex of_period = std::abs(x) < 1e-8 ? 1.0 : (1.0 - std::exp(-x)) / x;
    return std::exp(-x * law.delay_periods) * of_period;
}

/// v(z)/θ(z) at z = e^(jωT).
Complex filtered_velocity(double omega, const SampledLaw &law) {
    const Complex back = std::exp(Complex(0.0, -omega * law.period_s));
    return (1.0 - law.filter_pole) * (1.0 - back) / (law.period_s * (1.0 - law.filter_pole * back));
}

} // namespace

Complex tip_stiffness(const StabilityCase &which, const Vector3 &direction,
                      double omega_rad_per_s) {
    const StabilityCase all = whole(which);
    const LoopMember nobody{0, no_hand()};
    const DrivenLoad load = driven_load(all, nobody);
    const SampledLaw law = sampled_law(all, nobody);
    const Complex s(0.0, omega_rad_per_s);
    const Eigen::MatrixXcd command =
        hold(omega_rad_per_s, law) * (law.per_velocity * filtered_velocity(omega_rad_per_s, law) +
                                      law.per_position.cast<Complex>());
    Eigen::MatrixXcd motors(3, 3);
    for (Eigen::Index i = 0; i < 3; ++i) {
        Eigen::RowVectorXcd rate = load.current_rate_per_command[i] * command.row(i);
        rate[i] += load.current_rate_per_velocity[i] * s;
        motors.row(i) = -load.torque_Nm_per_A[i] / (s - load.current_rate_per_current[i]) * rate;
    }
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
    const LoopMember nobody{0, no_hand()};
    const DrivenLoad load = driven_load(all, nobody);
    const SampledLaw law = sampled_law(all, nobody);
    const Matrix3 command =
        which.device.rad_per_count() *
        ((1.0 - law.filter_pole) / law.period_s * law.per_velocity + law.per_position);
    const Matrix3 current_A = sampled_load(load, which.period_s).block<3, 3>(6, 9) * command;
    const Matrix3 J = device::motor_jacobian(which.device.geometry, which.q_rad);
    const Matrix3 force_N = J.transpose().inverse() * load.torque_Nm_per_A.asDiagonal() * current_A;
    return force_N.colwise().norm().maxCoeff();
}

} // namespace springdrive::loops
