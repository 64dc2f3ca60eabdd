// Where the transpose map (23) no longer shapes the stiffness: the force's direction above about λ.
#pragma once

#include "engine/lab/limits/method_limits/method_limit.h"
#include "engine/lab/loops/stability_case.h"

namespace springdrive::limits {

/// The name of the method in the table.
inline constexpr const char *kTransposeKinematics = "transpose kinematics (23)";

/// The frequency of vibration above which forces deviate from the normal by more than the angle
/// that the paper quotes as perceptible. Predicted by the sampled form of direction_spectrum.h,
/// measured by vibrating the motors under the law itself.
[[nodiscard]] LimitTrial direction_trial(const loops::StabilityCase &which);

} // namespace springdrive::limits
