#include "engine/lab/limits/method_limits/late_ticks.h"

#include "base/assertions.h"
#include "base/eigenvalues.h"

namespace springdrive::limits {

double late_ticks_eigenvalue(const loops::StabilityCase &which, const loops::LoopMember &member,
                             int missed) {
    SPRINGDRIVE_ASSERT(which.delay_periods == 0.0);
    const loops::DrivenLoad load = loops::driven_load(which, member);
    SPRINGDRIVE_ASSERT_AUDIT(loops::pulls_on_all_positions(
        loops::sampled_law(which, member).per_position, load.stiffness_Nm_per_rad));
    const double T = which.period_s;
    // A tick differentiates the motion since the last one over the time since the last one.
    const auto law = [&](int periods) {
        loops::StabilityCase at = which;
        at.period_s = periods * T;
        return loops::sampled_law(at, member);
    };
    // Each tick's command is held until the next one.
    const Eigen::MatrixXd until_late =
        loops::one_period_map(loops::sampled_load(load, (1 + missed) * T), law(1));
    const Eigen::MatrixXd until_on_time =
        loops::one_period_map(loops::sampled_load(load, T), law(1 + missed));
    return eigenvalues(until_on_time * until_late).cwiseAbs().maxCoeff();
}

} // namespace springdrive::limits
