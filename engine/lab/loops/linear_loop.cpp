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

/// The directions of x in which law or load exert a restoring force: those of the motors as
/// columns, and how further bodies follow the motors at rest, x_b = G θ.
struct PulledPositions {
    MatrixXd motors;
    MatrixXd follow; ///< G
};

/// K as the motors feel it at rest: K_θθ + K_θb G, with G = −K_bb⁻¹ K_bθ.
MatrixXd stiffness_at_motors(const MatrixXd &stiffness, const MatrixXd &follow) {
    const Index motors = follow.cols();
    const Index others = follow.rows();
    MatrixXd at_motors = stiffness.topLeftCorner(motors, motors);
    if (others > 0) {
        // Where no spring leads to the ground, only round-off remains. Springs of the structure are
        // at most some 1e6 times as stiff as a light hand, with round-off of 1e-12.
        constexpr double kRoundOff = 1e-9;
        const double scale = at_motors.norm();
        at_motors += stiffness.topRightCorner(motors, others) * follow;
        if (at_motors.norm() < kRoundOff * scale) {
            at_motors.setZero();
        }
    }
    return at_motors;
}

PulledPositions pulled_positions(const MatrixXd &per_position, const MatrixXd &stiffness) {
    const Index motors = per_position.cols();
    const Index others = stiffness.rows() - motors;
    PulledPositions pulled;
    pulled.follow = MatrixXd::Zero(others, motors);
    if (others > 0) {
        pulled.follow = -stiffness.bottomRightCorner(others, others)
                             .llt()
                             .solve(stiffness.bottomLeftCorner(others, motors));
    }
    const auto weighed = [](const MatrixXd &pull) -> MatrixXd {
        const double scale = pull.squaredNorm();
        return scale > 0.0 ? MatrixXd(pull.transpose() * pull / scale)
                           : MatrixXd::Zero(pull.cols(), pull.cols());
    };
    // On squared values: a direction counts as pulled from 1e-6 of the strongest pull on.
    constexpr double kPulled = 1e-12;
    const Modes modes = symmetric_modes(weighed(per_position) +
                                        weighed(stiffness_at_motors(stiffness, pulled.follow)));
    const Index free = (modes.eigenvalues.array() < kPulled).count();
    pulled.motors = modes.eigenvectors.rightCols(motors - free);
    return pulled;
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

DrivenLoad DrivenLoad::of(Index motors, Index coordinates) {
    SPRINGDRIVE_ASSERT(coordinates >= motors);
    const MatrixXd nothing = MatrixXd::Zero(coordinates, coordinates);
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
    const Index n = load.coordinates();
    const Index m = load.motors();
    MatrixXd torque = MatrixXd::Zero(n, m);
    torque.topRows(m).diagonal() = load.torque_Nm_per_A;
    MatrixXd rates = MatrixXd::Zero(2 * (n + m), 2 * (n + m)); // of [x, ẋ, i, u]
    const Eigen::LLT<MatrixXd> inertia(load.inertia_kg_m2);
    rates.block(0, n, n, n).setIdentity();
    rates.block(n, 0, n, n) = -inertia.solve(load.stiffness_Nm_per_rad);
    rates.block(n, n, n, n) = -inertia.solve(load.damping_Nms_per_rad);
    rates.block(n, 2 * n, n, m) = inertia.solve(torque);
    rates.block(2 * n, n, m, m).diagonal() = load.current_rate_per_velocity;
    rates.block(2 * n, 2 * n, m, m).diagonal() = load.current_rate_per_current;
    rates.block(2 * n, 2 * n + m, m, m).diagonal() = load.current_rate_per_command;
    const MatrixXd whole = (rates * period_s).exp();
    return whole.topRows(2 * n + m);
}

MatrixXd sampled_load(const DrivenLoad &load, double period_s, double delay_periods) {
    const double fraction = device::split_delay(delay_periods).fraction;
    if (fraction == 0.0) {
        return sampled_load(load, period_s);
    }
    const Index states = 2 * load.coordinates() + load.motors();
    const MatrixXd first = sampled_load(load, fraction * period_s);
    const MatrixXd second = sampled_load(load, (1.0 - fraction) * period_s);
    MatrixXd both(states, states + 2 * load.motors());
    both << second.leftCols(states) * first, second.rightCols(load.motors());
    return both;
}

MatrixXd one_period_map(const MatrixXd &load, const SampledLaw &law) {
    const Index m = law.per_velocity.rows();
    const Index n = (load.rows() - m) / 2;
    const device::SplitDelay delay = device::split_delay(law.delay_periods);
    const Index held = delay.held();
    SPRINGDRIVE_ASSERT(load.rows() == 2 * n + m &&
                       load.cols() == load.rows() + (delay.fraction > 0.0 ? 2 : 1) * m);
    const StateStarts at(m, n);
    const Index states = at.first_held + m * held;
    const auto selector = [states](Index start, Index count) {
        MatrixXd rows = MatrixXd::Zero(count, states);
        rows.middleCols(start, count).setIdentity();
        return rows;
    };

    const double a = law.filter_pole;
    const MatrixXd v =
        a * selector(at.velocity, m) + (1.0 - a) / law.period_s * selector(at.moved, m);
    const MatrixXd u = law.per_velocity * v + law.per_position * selector(at.position, m);
    const auto command = [&](Index back) { // u[k − back]
        return back == 0 ? u : selector(at.first_held + m * (back - 1), m);
    };

    MatrixXd before(load.cols(), states); // [x, ẋ, i, u] or [x, ẋ, i, u_old, u_new]
    if (delay.fraction > 0.0) {
        before << selector(at.position, n), selector(at.rate, n), selector(at.current, m),
            command(delay.whole + 1), command(delay.whole);
    } else {
        before << selector(at.position, n), selector(at.rate, n), selector(at.current, m),
            command(delay.whole);
    }
    const MatrixXd after = load * before;

    MatrixXd map = MatrixXd::Zero(states, states);
    map.middleRows(at.position, n) = after.topRows(n);
    map.middleRows(at.moved, m) = after.topRows(m) - before.topRows(m);
    map.middleRows(at.rate, n) = after.middleRows(n, n);
    map.middleRows(at.current, m) = after.middleRows(2 * n, m);
    map.middleRows(at.velocity, m) = v;
    if (held > 0) {
        map.middleRows(at.first_held, m) = u;
        map.block(at.first_held + m, at.first_held, m * (held - 1), m * (held - 1)).setIdentity();
    }
    return map;
}

bool pulls_on_all_positions(const MatrixXd &per_position, const MatrixXd &stiffness_Nm_per_rad) {
    return pulled_positions(per_position, stiffness_Nm_per_rad).motors.cols() ==
           per_position.cols();
}

double largest_eigenvalue(const MatrixXd &map, const SampledLaw &law,
                          const MatrixXd &stiffness_Nm_per_rad) {
    const PulledPositions pulled = pulled_positions(law.per_position, stiffness_Nm_per_rad);
    const Index m = pulled.motors.rows();
    const Index kept = pulled.motors.cols();
    if (kept == m) {
        return eigenvalues(map).cwiseAbs().maxCoeff();
    }
    // Further bodies are counted from where they would rest, x_b − G θ: then a free direction is
    // one of the motors alone, and leaving it out changes nothing else.
    const Index bodies = pulled.follow.rows();
    const Index others = map.rows() - m;
    MatrixXd onto = MatrixXd::Zero(kept + others, map.rows());
    onto.topLeftCorner(kept, m) = pulled.motors.transpose();
    onto.bottomRightCorner(others, others).setIdentity();
    MatrixXd back = onto.transpose();
    onto.block(kept, 0, bodies, m) = -pulled.follow;
    back.block(m, 0, bodies, kept) = pulled.follow * pulled.motors;
    return eigenvalues(onto * map * back).cwiseAbs().maxCoeff();
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
    MatrixXd stiffness = load.stiffness_Nm_per_rad;
    stiffness.topLeftCorner(load.motors(), load.motors()) -=
        torque_per_command.asDiagonal() * law.per_position;
    return stiffness;
}

VectorXd static_squares(const DrivenLoad &load, const SampledLaw &law) {
    return eigenvalues(load.inertia_kg_m2.llt().solve(static_stiffness(load, law))).real();
}

} // namespace springdrive::loops
