// Where the transpose map (23) no longer shapes stiffness: directions of force above about λ.
#pragma once

#include "engine/analysis/failure_lines/failure_line.h"
#include "engine/analysis/stability/stability_case.h"

namespace springdrive {

/// The frequency of vibration above which forces are turned away from the normal by more than what
/// the paper quotes as perceptible. Predicted by the sampled form of direction_spectrum.h, measured
/// by shaking the motors under the law itself.
[[nodiscard]] TriedLine direction_line(const StabilityCase &which);

} // namespace springdrive
