// What a work-precision chart is made of: what a method costs, and how far from the truth it is.
#pragma once

#include <string>
#include <vector>

namespace springdrive::rig {

/// A time that was taken several times over: what the machine allows, and how it scatters.
struct Cost {
    double least_ns = 0.0;
    double median_ns = 0.0;
    double greatest_ns = 0.0;
};

/// One method at one setting.
struct WorkPoint {
    std::string method;  ///< the line that it belongs to
    std::string setting; ///< "100 µs", "1280 triangles"
    Cost cost;
    double error = 0.0; ///< against a reference that shares nothing with the method
    bool stable = true; ///< false: it ran away, and `error` says nothing
};

/// One picture.
struct WorkPrecisionChart {
    std::string name; ///< of its files: "integrators"
    std::string title;
    std::string cost_label;  ///< of what, without a unit: the axis says ns, µs or ms by itself
    std::string error_label; ///< with its unit and what it is held against
    std::vector<WorkPoint> points;
};

} // namespace springdrive::rig
