// What assets/figures/work_precision.gnuplot is told of a chart beside its CSV file.
#pragma once

#include "app/figures/figure.h"
#include "engine/analysis/work_precision/work_point.h"

#include <string>

namespace springdrive {

/// Title, labels, methods, the ranges of both axes and which points are named in the picture.
///
/// The ranges hold every point. An error of 0, which no logarithmic axis has, stands apart at the
/// bottom; one that is not finite on the upper edge.
[[nodiscard]] ChartMarks work_precision_marks(const WorkPrecisionChart &chart,
                                              const std::string &footnote);

} // namespace springdrive
