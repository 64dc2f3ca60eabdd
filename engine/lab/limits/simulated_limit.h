// Where stability ends along one parameter, found by trying. The prediction says where to look, and
// no more: each verdict is that of trials.
#pragma once

#include "engine/lab/limits/stability_limits.h"

namespace springdrive::limits {

/// The last stable value by trials, to 1e-3 of it. Nothing where no trial differs within the
/// parameter's range, or a factor of 4 about the prediction.
///
/// Without effects a loop has but one limit near the prediction, which is searched for from there
/// outwards. With them it may rest, rattle and rest again along a parameter. Then the limit is the
/// first that is met from the stable side: values from half the prediction outwards (one and a half
/// where stability begins there) are tried in steps of a tenth of it, of a twentieth within a fifth
/// of it, and wider beyond. What fails on less than a step is not seen.
[[nodiscard]] std::optional<double> simulated_limit(const loops::StabilityCase &which,
                                                    const loops::StabilityParameter &parameter,
                                                    const StabilityLimit &predicted,
                                                    const TrialOptions &options);

} // namespace springdrive::limits
