#include "engine/lab/loops/linear_loop.h"

#include "base/assertions.h"
#include "base/eigenvalues.h"
#include "device/core/split_delay.h"
#include "engine/control/velocity_filter.h"

#include <Eigen/Cholesky>
#include <unsupported/Eigen/MatrixFunctions>

#include <cmath>
#include <complex>
#include <utility>

namespace springdrive::loops {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Complex = std::complex<double>;

/// The rows of one block of states, as a selector.
class Blocks {
public:
    Blocks(Index motors, Index count) : motors_(motors), count_(count) {}

    [[nodiscard]] Index states() const { return motors_ * count_; }
    [[nodiscard]] Index at(Index block) const { return motors_ * block; }
    [[nodiscard]] MatrixXd selector(Index block) const {
        MatrixXd rows = MatrixXd::Zero(motors_, states());
        rows.middleCols(at(block), motors_).setIdentity();
        return rows;
    }

private:
    Index motors_;
    Index count_;
};

/// An orthonormal basis of the positions on which law or load exert a restoring force, one column
/// for each.
MatrixXd pulled_positions(const MatrixXd &per_position, const MatrixXd &stiffness) {
    const auto weighed = [](const MatrixXd &pull) -> MatrixXd {
        const double scale = pull.squaredNorm();
        return scale > 0.0 ? MatrixXd(pull.transpose() * pull / scale)
                           : MatrixXd::Zero(pull.cols(), pull.cols());
    };
    // On squared values: a direction counts as pulled from 1e-6 of the strongest pull on.
    constexpr double kPulled = 1e-12;
    const Modes modes = symmetric_modes(weighed(per_position) + weighed(stiffness));
    const Index free = (modes.eigenvalues.array() < kPulled).count();
    return modes.eigenvectors.rightCols(per_position.cols() - free);
}

/// 1 − e^(−jx) without the cancellation at small x.
Complex one_minus_turn(double x) {
    const double half = std::sin(0.5 * x);
    return {2.0 * half * half, std::sin(x)};
}

/// H(jω): the frequency response of a zero-order hold that is d periods late.
Complex hold(double omega_rad_per_s, double period_s, double delay_periods) {
    const double x = omega_rad_per_s * period_s;
    if (x == 0.0) {
        return 1.0;
    }
    return std::polar(1.0, -x * delay_periods) * one_minus_turn(x) / Complex(0.0, x);
}

/// D(e^(jωT)): the frequency response of the velocity filter.
Complex filtered_rate(double omega_rad_per_s, double pole, double period_s) {
    const Complex difference = one_minus_turn(omega_rad_per_s * period_s);
    // 1 − a z⁻¹ = (1 − a) + a (1 − z⁻¹)
    return (1.0 - pole) * difference / (period_s * (1.0 - pole + pole * difference));
}

} // namespace

DrivenLoad DrivenLoad::of(Index motors) {
    const MatrixXd nothing = MatrixXd::Zero(motors, motors);
    const VectorXd none = VectorXd::Zero(motors);
    return {nothing, nothing, nothing, none, none, none, none};
}

void DrivenLoad::put_behind_spring_drive(Index motor, const device::MotorParameters &parameters,
                                         double dR_Ohm) {
    const double L = parameters.inductance_H;
    const double k_T = parameters.torque_constant_Nm_per_A;
    torque_Nm_per_A[motor] = k_T;
    current_rate_per_current[motor] = -dR_Ohm / L;
    current_rate_per_velocity[motor] = -k_T / L;
    current_rate_per_command[motor] = 1.0 / L;
}

void DrivenLoad::put_behind_current_drive(Index motor, const device::MotorParameters &parameters,
                                          double bandwidth_rad_per_s) {
    torque_Nm_per_A[motor] = parameters.torque_constant_Nm_per_A;
    current_rate_per_current[motor] = -bandwidth_rad_per_s;
    current_rate_per_velocity[motor] = 0.0;
    current_rate_per_command[motor] = bandwidth_rad_per_s;
}

SampledLaw drift_compensation(const VectorXd &k_T, const Gains &gains, const MatrixXd &A,
                              const Sampling &sampling) {
    const MatrixXd all = MatrixXd::Identity(A.rows(), A.cols());
    return {MatrixXd(k_T.asDiagonal() * (all - A) - gains.K_D_Vs_per_rad * A),
            MatrixXd(-gains.K_P_V_per_rad * A),
            control::velocity_filter_pole(gains.lambda_rad_per_s, sampling.period_s),
            sampling.period_s, sampling.delay_periods};
}

MatrixXd sampled_load(const DrivenLoad &load, double period_s) {
    const Index n = load.motors();
    MatrixXd rates = MatrixXd::Zero(4 * n, 4 * n); // of [θ, θ̇, i, u]
    const Eigen::LLT<MatrixXd> inertia(load.inertia_kg_m2);
    rates.block(0, n, n, n).setIdentity();
    rates.block(n, 0, n, n) = -inertia.solve(load.stiffness_Nm_per_rad);
    rates.block(n, n, n, n) = -inertia.solve(load.damping_Nms_per_rad);
    rates.block(n, 2 * n, n, n) = inertia.solve(MatrixXd(load.torque_Nm_per_A.asDiagonal()));
    rates.block(2 * n, n, n, n).diagonal() = load.current_rate_per_velocity;
    rates.block(2 * n, 2 * n, n, n).diagonal() = load.current_rate_per_current;
    rates.block(2 * n, 3 * n, n, n).diagonal() = load.current_rate_per_command;
    const MatrixXd whole = (rates * period_s).exp();
    return whole.topRows(3 * n);
}

MatrixXd sampled_load(const DrivenLoad &load, double period_s, double delay_periods) {
    const double fraction = device::split_delay(delay_periods).fraction;
    if (fraction == 0.0) {
        return sampled_load(load, period_s);
    }
    const Index n = load.motors();
    const MatrixXd first = sampled_load(load, fraction * period_s);
    const MatrixXd second = sampled_load(load, (1.0 - fraction) * period_s);
    MatrixXd both(3 * n, 5 * n);
    both << second.leftCols(3 * n) * first, second.rightCols(n);
    return both;
}

MatrixXd one_period_map(const MatrixXd &load, const SampledLaw &law) {
    using enum StateBlock::Start;
    const Index n = law.per_velocity.rows();
    const device::SplitDelay delay = device::split_delay(law.delay_periods);
    const Index held = delay.held();
    SPRINGDRIVE_ASSERT(load.cols() == (delay.fraction > 0.0 ? 5 : 4) * n);
    const Blocks blocks(n, first_held + held);

    const double a = law.filter_pole;
    const MatrixXd v =
        a * blocks.selector(velocity) + (1.0 - a) / law.period_s * blocks.selector(moved);
    const MatrixXd u = law.per_velocity * v + law.per_position * blocks.selector(theta);
    const auto command = [&](Index back) { // u[k − back]
        return back == 0 ? u : blocks.selector(first_held + back - 1);
    };

    MatrixXd before(load.cols(), blocks.states()); // [θ, θ̇, i, u] or [θ, θ̇, i, u_old, u_new]
    if (delay.fraction > 0.0) {
        before << blocks.selector(theta), blocks.selector(rate), blocks.selector(current),
            command(delay.whole + 1), command(delay.whole);
    } else {
        before << blocks.selector(theta), blocks.selector(rate), blocks.selector(current),
            command(delay.whole);
    }
    const MatrixXd after = load * before;

    MatrixXd map = MatrixXd::Zero(blocks.states(), blocks.states());
    map.middleRows(blocks.at(theta), n) = after.topRows(n);
    map.middleRows(blocks.at(moved), n) = after.topRows(n) - before.topRows(n);
    map.middleRows(blocks.at(rate), n) = after.middleRows(n, n);
    map.middleRows(blocks.at(current), n) = after.middleRows(2 * n, n);
    map.middleRows(blocks.at(velocity), n) = v;
    if (held > 0) {
        map.middleRows(blocks.at(first_held), n) = u;
        map.block(blocks.at(first_held + 1), blocks.at(first_held), n * (held - 1), n * (held - 1))
            .setIdentity();
    }
    return map;
}

bool pulls_on_all_positions(const MatrixXd &per_position, const MatrixXd &stiffness_Nm_per_rad) {
    return pulled_positions(per_position, stiffness_Nm_per_rad).cols() == per_position.cols();
}

double largest_eigenvalue(const MatrixXd &map, const SampledLaw &law,
                          const MatrixXd &stiffness_Nm_per_rad) {
    const Index n = law.per_position.cols();
    const MatrixXd pulled = pulled_positions(law.per_position, stiffness_Nm_per_rad);
    if (pulled.cols() == n) {
        return eigenvalues(map).cwiseAbs().maxCoeff();
    }
    const Index others = map.rows() - n;
    MatrixXd onto = MatrixXd::Zero(pulled.cols() + others, map.rows());
    onto.topLeftCorner(pulled.cols(), n) = pulled.transpose();
    onto.bottomRightCorner(others, others).setIdentity();
    return eigenvalues(onto * map * onto.transpose()).cwiseAbs().maxCoeff();
}

LinearLoop::LinearLoop(DrivenLoad load, const Sampling &sampling)
    : load_(std::move(load)), sampling_(sampling),
      sampled_load_(sampled_load(load_, sampling.period_s, sampling.delay_periods)) {}

MatrixXd LinearLoop::one_period_map(const SampledLaw &law) const {
    SPRINGDRIVE_ASSERT(law.period_s == sampling_.period_s &&
                       law.delay_periods == sampling_.delay_periods);
    return loops::one_period_map(sampled_load_, law);
}

double LinearLoop::largest_eigenvalue(const SampledLaw &law) const {
    return loops::largest_eigenvalue(one_period_map(law), law, load_.stiffness_Nm_per_rad);
}

Eigen::MatrixXcd motor_stiffness(const DrivenLoad &load, const SampledLaw &law,
                                 double omega_rad_per_s) {
    const Complex s(0.0, omega_rad_per_s);
    const Complex D = filtered_rate(omega_rad_per_s, law.filter_pole, law.period_s);
    const Complex H = hold(omega_rad_per_s, law.period_s, law.delay_periods);
    Eigen::MatrixXcd stiffness = H * (law.per_velocity * D + law.per_position.cast<Complex>());
    for (Index i = 0; i < load.motors(); ++i) {
        Eigen::RowVectorXcd current_rate = load.current_rate_per_command[i] * stiffness.row(i);
        current_rate[i] += load.current_rate_per_velocity[i] * s;
        stiffness.row(i) =
            -load.torque_Nm_per_A[i] / (s - load.current_rate_per_current[i]) * current_rate;
    }
    return stiffness;
}

MatrixXd static_stiffness(const DrivenLoad &load, const SampledLaw &law) {
    const VectorXd torque_per_command =
        -load.torque_Nm_per_A.cwiseProduct(load.current_rate_per_command)
             .cwiseQuotient(load.current_rate_per_current);
    return load.stiffness_Nm_per_rad - torque_per_command.asDiagonal() * law.per_position;
}

VectorXd static_squares(const DrivenLoad &load, const SampledLaw &law) {
    return eigenvalues(load.inertia_kg_m2.llt().solve(static_stiffness(load, law))).real();
}

} // namespace springdrive::loops
