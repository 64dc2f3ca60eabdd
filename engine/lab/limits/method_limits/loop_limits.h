// Where sampled loops become unstable: drift compensation (10), the scale of the transpose map
// (23), and the virtual wall of a current drive.
#pragma once

#include "engine/lab/limits/method_limits/method_limit.h"
#include "engine/lab/loops/stability_case.h"

namespace springdrive::limits {

/// Each limit of a loop, by eigenvalues and by trials, from `stability_limits`; and the change of
/// e_W per encoder count.
/// @param step  called `kDriftSteps` times in all
[[nodiscard]] std::vector<MethodLimit> drift_limits(const loops::StabilityCase &which,
                                                    const std::function<void()> &step);
inline constexpr int kDriftSteps = 7;

[[nodiscard]] std::vector<MethodLimit> alpha_limits(const loops::StabilityCase &which);
[[nodiscard]] std::vector<MethodLimit> wall_limits(const loops::StabilityCase &which);

} // namespace springdrive::limits
