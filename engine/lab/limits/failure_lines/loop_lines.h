// Where sampled loops become unstable: drift compensation (10), the scale of the transpose map
// (23), and the virtual wall of a current drive.
#pragma once

#include "engine/lab/limits/failure_lines/failure_line.h"
#include "engine/lab/loops/stability_case.h"

namespace springdrive::limits {

/// Each limit of a loop, by eigenvalues and by trials, from `stability_limits`; and the change of
/// e_W per encoder count.
/// @param step  called `kDriftSteps` times in all
[[nodiscard]] std::vector<FailureLine> drift_lines(const loops::StabilityCase &which,
                                                   const std::function<void()> &step);
inline constexpr int kDriftSteps = 7;

[[nodiscard]] std::vector<FailureLine> alpha_lines(const loops::StabilityCase &which);
[[nodiscard]] std::vector<FailureLine> wall_lines(const loops::StabilityCase &which);

} // namespace springdrive::limits
