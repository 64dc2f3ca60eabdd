#include "engine/lab/loops/closed_loop.h"

#include "base/assertions.h"
#include "device/core/split_delay.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <unsupported/Eigen/MatrixFunctions>

namespace springdrive::loops {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Where the states begin, in blocks of one for each motor.
enum Block : Index { theta, moved, rate, current, velocity, first_held };

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

/// An orthonormal basis of the positions that law or load pull back, one column for each.
MatrixXd pulled_positions(const MatrixXd &per_position, const MatrixXd &stiffness) {
    const auto weighed = [](const MatrixXd &pull) -> MatrixXd {
        const double scale = pull.squaredNorm();
        return scale > 0.0 ? MatrixXd(pull.transpose() * pull / scale)
                           : MatrixXd::Zero(pull.cols(), pull.cols());
    };
    // Of squares, so that a direction counts as pulled from 1e-6 of the strongest pull on.
    constexpr double kPulled = 1e-12;
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(weighed(per_position) +
                                                         weighed(stiffness));
    const Index free = (solver.eigenvalues().array() < kPulled).count();
    return solver.eigenvectors().rightCols(per_position.cols() - free);
}

} // namespace

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
        return map.eigenvalues().cwiseAbs().maxCoeff();
    }
    const Index others = map.rows() - n;
    MatrixXd onto = MatrixXd::Zero(pulled.cols() + others, map.rows());
    onto.topLeftCorner(pulled.cols(), n) = pulled.transpose();
    onto.bottomRightCorner(others, others).setIdentity();
    return MatrixXd(onto * map * onto.transpose()).eigenvalues().cwiseAbs().maxCoeff();
}

} // namespace springdrive::loops
