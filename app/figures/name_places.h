// Where the names of points stand in a chart, so that they cover neither one another nor a point.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace springdrive::app {

/// A place in a chart, as shares of its frame from the lower left corner.
struct Spot {
    double x = 0.0;
    double y = 0.0;
};

/// A straight piece of what is drawn.
struct Stroke {
    Spot from;
    Spot to;
};

/// On which side of its point a name stands, the better ones first.
enum class NameCorner { right_above, right_below, left_above, left_below };

/// A name of a point.
struct PointName {
    Spot point;
    std::size_t letters = 0;
};

/// For each name in turn the corner where it covers no point and no name before it, lies within the
/// frame and crosses the fewest strokes; none where there is no such corner with few of them.
///
/// Sizes are those of assets/figures/work_precision.gnuplot.
[[nodiscard]] std::vector<std::optional<NameCorner>>
name_corners(const std::vector<PointName> &names, const std::vector<Spot> &points,
             const std::vector<Stroke> &strokes);

} // namespace springdrive::app
