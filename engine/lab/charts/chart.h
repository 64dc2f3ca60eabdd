// A speed-accuracy chart: its setting, its points and its CSV file.
#pragma once

#include "base/table.h"
#include "base/timing.h"
#include "device/core/device_description.h"
#include "engine/control/tuning.h"

#include <functional>
#include <string>
#include <vector>

namespace springdrive::charts {

struct ChartSetting {
    device::DeviceDescription device;
    control::Tuning tuning;
    int repeats = 5; ///< how often each time is measured, at least once
};

/// One method at one setting.
struct ChartPoint {
    std::string method;  ///< the line that it belongs to
    std::string setting; ///< "100 µs", "1280 triangles"
    Cost cost;
    double error = 0.0; ///< against a reference that shares no code with the method
    bool stable = true; ///< false: it diverged, and `error` is meaningless
};

/// One picture.
struct SpeedAccuracyChart {
    std::string name; ///< of its files: "integrators"
    std::string title;
    std::string cost_label;  ///< without a unit: the axis adds ns, µs or ms
    std::string error_label; ///< with its unit and its reference
    std::vector<ChartPoint> points;
};

/// Receives the progress of a chart, from 0 to 1.
using ChartProgress = std::function<void(double share)>;

/// method, setting, the cost's minimum, median and maximum [ns], error, stable (1 or 0) and the
/// machine, a row for each point.
[[nodiscard]] Table chart_table(const SpeedAccuracyChart &chart, const std::string &machine);

} // namespace springdrive::charts
