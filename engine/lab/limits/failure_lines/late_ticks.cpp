#include "engine/lab/limits/failure_lines/late_ticks.h"

#include "base/assertions.h"

#include <Eigen/Eigenvalues>

namespace springdrive::limits {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// States, in blocks of one for each motor: θ, its way since the last tick, θ̇, i, θ̇_f and the
/// command in force.
enum Block : Index { theta, moved, rate, current, velocity, in_force };
constexpr Index kBlocks = in_force + 1;

class Maps {
public:
    explicit Maps(Index motors) : n_(motors) {}

    [[nodiscard]] MatrixXd identity() const { return MatrixXd::Identity(states(), states()); }

    /// Time goes on behind the command in force.
    [[nodiscard]] MatrixXd advance(const MatrixXd &load) const {
        MatrixXd before(4 * n_, states());
        before << rows(theta), rows(rate), rows(current), rows(in_force);
        const MatrixXd after = load * before;
        MatrixXd map = identity();
        map.middleRows(theta * n_, n_) = after.topRows(n_);
        map.middleRows(moved * n_, n_) = rows(moved) + after.topRows(n_) - rows(theta);
        map.middleRows(rate * n_, n_) = after.middleRows(n_, n_);
        map.middleRows(current * n_, n_) = after.bottomRows(n_);
        return map;
    }

    /// The law reads and answers.
    [[nodiscard]] MatrixXd tick(const loops::SampledLaw &law) const {
        const double a = law.filter_pole;
        const MatrixXd v = a * rows(velocity) + (1.0 - a) / law.period_s * rows(moved);
        MatrixXd map = identity();
        map.middleRows(moved * n_, n_).setZero();
        map.middleRows(velocity * n_, n_) = v;
        map.middleRows(in_force * n_, n_) = law.per_velocity * v + law.per_position * rows(theta);
        return map;
    }

private:
    [[nodiscard]] Index states() const { return kBlocks * n_; }
    [[nodiscard]] MatrixXd rows(Index block) const { return identity().middleRows(block * n_, n_); }

    Index n_;
};

} // namespace

double late_ticks_eigenvalue(const loops::StabilityCase &which, const loops::LoopMember &member,
                             int missed) {
    SPRINGDRIVE_ASSERT(which.delay_periods == 0.0);
    const loops::DrivenLoad load = loops::driven_load(which, member);
    SPRINGDRIVE_ASSERT_AUDIT(loops::pulls_on_all_positions(
        loops::sampled_law(which, member).per_position, load.stiffness_Nm_per_rad));
    const double T = which.period_s;
    // What a tick makes of the way since the last one goes with the time since the last one.
    const auto law = [&](int periods) {
        loops::StabilityCase at = which;
        at.period_s = periods * T;
        return loops::sampled_law(at, member);
    };
    const Maps maps(load.motors());
    const MatrixXd until_late =
        maps.advance(loops::sampled_load(load, (1 + missed) * T)) * maps.tick(law(1));
    const MatrixXd until_on_time =
        maps.advance(loops::sampled_load(load, T)) * maps.tick(law(1 + missed));
    return MatrixXd(until_on_time * until_late).eigenvalues().cwiseAbs().maxCoeff();
}

} // namespace springdrive::limits
