// The input of assets/figures/speed_accuracy.gnuplot in addition to the CSV file.
#pragma once

#include "app/figures/gnuplot.h"
#include "engine/lab/charts/charts.h"

#include <string>

namespace springdrive::app {

/// Title, labels, the legend with each method's first and last setting, the ranges of both axes.
///
/// The ranges include every point. An error of 0, which a logarithmic axis cannot show, is drawn
/// separately at the bottom; an error that is not finite, at the upper edge.
[[nodiscard]] ChartMarks speed_accuracy_marks(const charts::SpeedAccuracyChart &chart,
                                              const std::string &footnote);

} // namespace springdrive::app
