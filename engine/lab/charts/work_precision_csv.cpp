#include "engine/lab/charts/work_precision_csv.h"

#include <fmt/core.h>

#include <cmath>

namespace springdrive::charts {

namespace {

std::string cell(const std::string &text) {
    if (text.find_first_of(",\"\n\r") == std::string::npos) {
        return text;
    }
    std::string quoted = "\"";
    for (const char c : text) {
        quoted += c == '"' ? "\"\"" : std::string(1, c);
    }
    return quoted + '"';
}

std::string cell(double number) {
    return std::isfinite(number) ? fmt::format("{:.6g}", number) : "";
}

} // namespace

void write_work_precision_csv(std::ostream &out, const rig::WorkPrecisionChart &chart,
                              const std::string &machine) {
    out << "method,setting,cost_least_ns,cost_median_ns,cost_greatest_ns,error,stable,machine\n";
    for (const rig::WorkPoint &point : chart.points) {
        out << cell(point.method) << ',' << cell(point.setting) << ',' << cell(point.cost.least_ns)
            << ',' << cell(point.cost.median_ns) << ',' << cell(point.cost.greatest_ns) << ','
            << cell(point.error) << ',' << (point.stable ? 1 : 0) << ',' << cell(machine) << '\n';
    }
}

} // namespace springdrive::charts
