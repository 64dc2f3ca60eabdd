// Where stability ends along one parameter or two: predicted by eigenvalues, and found by trials.
#pragma once

#include "engine/lab/limits/stability_simulation.h"
#include "engine/lab/loops/stability_case.h"

#include <functional>
#include <optional>
#include <vector>

namespace springdrive::limits {

/// The range of values to examine.
struct ParameterRange {
    double from = 0.0;
    double to = 0.0; ///< above `from`
};

/// Values of a range, evenly spaced, or by equal ratios; its ends included.
[[nodiscard]] std::vector<double> spaced(const ParameterRange &range, int count, bool by_ratio);

/// One value at which stability ends or begins.
struct StabilityLimit {
    double predicted = 0.0; ///< the last stable value, to 1e-6 of it
    bool stable_below = true;
    loops::LoopMember worst; ///< the member that is unstable just beyond
    /// The last stable value by trials, see `simulated_limit`; nothing where none is found.
    std::optional<double> simulated_linear; ///< without counts, supply and friction
    std::optional<double> simulated;        ///< with counts and supply
    std::optional<double> simulated_all;    ///< with friction as well
};

/// The values at which the prediction changes within a range, by a scan of 60 values and bisection.
[[nodiscard]] std::vector<StabilityLimit>
predicted_limits(const loops::StabilityCase &which, const loops::StabilityParameter &parameter,
                 const ParameterRange &range);

/// The last stable value by trials, to 1e-3 of it. The prediction only gives the place to search:
/// each result is that of trials. Nothing where all trials agree within the parameter's range, or
/// within a factor of 4 of the prediction.
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

/// Predictions and trials, one thread for each kind of trial. Trials of one motor have rigid links:
/// with other structures there are predictions only.
[[nodiscard]] std::vector<StabilityLimit>
stability_limits(const loops::StabilityCase &which, const loops::StabilityParameter &parameter,
                 const ParameterRange &range);

// Stability over two parameters: the predicted boundary, and the motion that remains in trials.

/// One side of a map.
struct MapAxis {
    const loops::StabilityParameter *parameter = nullptr;
    ParameterRange range;
    int steps = 40; ///< number of values, ends included

    /// Evenly spaced on the parameter's scale.
    [[nodiscard]] std::vector<double> values() const {
        return spaced(range, steps, is_logarithmic());
    }
    /// Narrow ranges, and those that reach down to 0, are spaced linearly instead.
    [[nodiscard]] bool is_logarithmic() const {
        return parameter->logarithmic && range.from > 0.0 && range.to > 4.0 * range.from;
    }
};

struct MapCell {
    double x = 0.0;
    double y = 0.0;
    double eigenvalue = 0.0; ///< the largest of all members
    bool stable = true;      ///< by trial
    /// The tip's maximum speed in the last tenth of a second of the worst trial [m/s].
    double remaining_m_per_s = 0.0;
};

/// Row by row, x running fastest, on all processors.
///
/// A trial releases the tip a millimetre from rest, one motor alone on rigid links, and records its
/// motion for a second. The members are tried in the order in which they are predicted to fail,
/// until one does; with the whole linkage, whose trials take long, only the two worst.
/// @param progress  receives a share from 0 to 1, from one thread at a time
[[nodiscard]] std::vector<MapCell> stability_map(const loops::StabilityCase &which,
                                                 const MapAxis &x, const MapAxis &y,
                                                 const std::function<void(double)> &progress);

} // namespace springdrive::limits
