// The data of a speed-accuracy chart: cost and error of a method.
#pragma once

#include <string>
#include <vector>

namespace springdrive::rig {

/// A time measured repeatedly: its minimum, median and maximum.
struct Cost {
    double min_ns = 0.0;
    double median_ns = 0.0;
    double max_ns = 0.0;
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

} // namespace springdrive::rig
