// Where stability ends along one parameter: predicted by eigenvalues, and found by trials.
#pragma once

#include "engine/lab/limits/stability_simulation.h"
#include "engine/lab/loops/stability_parameters.h"

#include <optional>
#include <vector>

namespace springdrive::limits {

/// The range of values to examine.
struct ParameterRange {
    double from = 0.0;
    double to = 0.0; ///< above `from`
};

/// One value at which stability ends or begins.
struct StabilityLimit {
    double predicted = 0.0; ///< the last stable value, to 1e-6 of it
    bool stable_below = true;
    loops::LoopMember worst; ///< the member that is unstable just beyond
    /// The last stable value by trials, see simulated_limit.h; nothing where none is found.
    std::optional<double> simulated_linear; ///< without counts, supply and friction
    std::optional<double> simulated;        ///< with counts and supply
    std::optional<double> simulated_all;    ///< with friction as well
};

/// The values at which the prediction changes within a range, by a scan of 60 values and bisection.
[[nodiscard]] std::vector<StabilityLimit>
predicted_limits(const loops::StabilityCase &which, const loops::StabilityParameter &parameter,
                 const ParameterRange &range);

/// Predictions and trials, one thread for each kind of trial.
[[nodiscard]] std::vector<StabilityLimit>
stability_limits(const loops::StabilityCase &which, const loops::StabilityParameter &parameter,
                 const ParameterRange &range);

} // namespace springdrive::limits
