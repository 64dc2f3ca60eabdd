// Where stability ends along one parameter, found by trials. The prediction only gives the place to
// search: each result is that of trials.
#pragma once

#include "engine/lab/limits/stability_limits.h"

namespace springdrive::limits {

/// The last stable value by trials, to 1e-3 of it. Nothing where all trials agree within the
/// parameter's range, or within a factor of 4 of the prediction.
///
/// Without effects a loop has only one limit near the prediction, which is searched for from there
/// outwards. With them it may come to rest, vibrate and come to rest again along a parameter. Then
/// the limit is the first one from the stable side: values from half the prediction outwards (one
/// and a half where stability begins there) are tried in steps of a tenth of it, of a twentieth
/// within a fifth of it, and wider beyond. Failures over less than a step are missed.
[[nodiscard]] std::optional<double> simulated_limit(const loops::StabilityCase &which,
                                                    const loops::StabilityParameter &parameter,
                                                    const StabilityLimit &predicted,
                                                    const TrialOptions &options);

} // namespace springdrive::limits
