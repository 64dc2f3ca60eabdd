// Stability over two parameters: the predicted boundary, and the motion that remains in trials.
#pragma once

#include "engine/lab/limits/stability_limits.h"

#include <functional>
#include <vector>

namespace springdrive::limits {

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
/// A trial releases the tip a millimetre from rest and records its motion for a second. The members
/// are tried in the order in which they are predicted to fail, until one does; with the whole
/// linkage, whose trials take long, only the two worst.
/// @param progress  receives a share from 0 to 1, from one thread at a time
[[nodiscard]] std::vector<MapCell> stability_map(const loops::StabilityCase &which,
                                                 const MapAxis &x, const MapAxis &y,
                                                 const std::function<void(double)> &progress);

} // namespace springdrive::limits
