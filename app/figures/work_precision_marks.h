// What assets/figures/work_precision.gnuplot is told of a chart beside its CSV file.
#pragma once

#include "app/figures/figure.h"
#include "engine/lab/rig/work_point.h"

#include <string>

namespace springdrive::app {

/// Title, labels, the legend with each method's first and last setting, the ranges of both axes.
///
/// The ranges hold every point. An error of 0, which no logarithmic axis has, stands apart at the
/// bottom; one that is not finite on the upper edge.
[[nodiscard]] ChartMarks work_precision_marks(const rig::WorkPrecisionChart &chart,
                                              const std::string &footnote);

} // namespace springdrive::app
