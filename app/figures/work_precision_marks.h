// The input of assets/figures/work_precision.gnuplot in addition to the CSV file.
#pragma once

#include "app/figures/figure.h"
#include "engine/lab/rig/work_point.h"

#include <string>

namespace springdrive::app {

/// Title, labels, the legend with each method's first and last setting, the ranges of both axes.
///
/// The ranges include every point. An error of 0, which a logarithmic axis cannot show, is drawn
/// separately at the bottom; an error that is not finite, at the upper edge.
[[nodiscard]] ChartMarks work_precision_marks(const rig::WorkPrecisionChart &chart,
                                              const std::string &footnote);

} // namespace springdrive::app
