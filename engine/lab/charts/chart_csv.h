// A speed-accuracy chart as a CSV file.
#pragma once

#include "engine/lab/rig/chart_point.h"

#include <ostream>
#include <string>

namespace springdrive::charts {

/// method, setting, the cost's minimum, median and maximum [ns], error, stable (1 or 0) and the
/// machine, a row for each point. An error that is not finite becomes an empty cell. Text with a
/// comma, a quote or an end of line is quoted (RFC 4180).
void write_chart_csv(std::ostream &out, const rig::SpeedAccuracyChart &chart,
                     const std::string &machine);

} // namespace springdrive::charts
