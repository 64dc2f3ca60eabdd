// What assets/figures/work_precision.gnuplot is told of a chart beside its CSV file.
#pragma once

#include "app/figures/figure.h"
#include "engine/lab/rig/work_point.h"

#include <string>

namespace springdrive::app {

/// Title, labels, methods, the ranges of both axes and which points are named in the picture.
///
/// The ranges hold every point. An error of 0, which no logarithmic axis has, stands apart at the
/// bottom; one that is not finite on the upper edge.
[[nodiscard]] ChartMarks work_precision_marks(const rig::WorkPrecisionChart &chart,
                                              const std::string &footnote);

} // namespace springdrive::app
