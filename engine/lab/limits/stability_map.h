// Stability over two parameters: the prediction's line, and the field that trials leave behind.
#pragma once

#include "engine/lab/limits/stability_limits.h"

#include <functional>
#include <vector>

namespace springdrive::limits {

/// One side of a map.
struct MapAxis {
    const loops::StabilityParameter *parameter = nullptr;
    ParameterRange range;
    int steps = 40; ///< values, the ends included

    /// Evenly spread by the parameter's own scale.
    [[nodiscard]] std::vector<double> values() const;
    /// Ranges that are narrow, or reach down to 0, are spread by differences instead.
    [[nodiscard]] bool is_logarithmic() const {
        return parameter->logarithmic && range.from > 0.0 && range.to > 4.0 * range.from;
    }
};

struct MapCell {
    double x = 0.0;
    double y = 0.0;
    double eigenvalue = 0.0; ///< the largest of all members
    bool stable = true;      ///< by trial
    /// The tip's greatest speed in the last tenth of a second of the worst trial [m/s].
    double remaining_m_per_s = 0.0;
};

/// Row by row, x running fastest, on all processors.
///
/// A trial lets go of the tip a millimetre aside and watches for a second. The members are tried
/// in the order in which they are predicted to fail, until one does; of the whole linkage, whose
/// trials take long, the two worst.
/// @param progress  told a share from 0 to 1, from one thread at a time
[[nodiscard]] std::vector<MapCell> stability_map(const loops::StabilityCase &which,
                                                 const MapAxis &x, const MapAxis &y,
                                                 const std::function<void(double)> &progress);

} // namespace springdrive::limits
