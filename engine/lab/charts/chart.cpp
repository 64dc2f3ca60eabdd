#include "engine/lab/charts/chart.h"

#include "base/print.h"

namespace springdrive::charts {

void write_chart_csv(std::ostream &out, const SpeedAccuracyChart &chart,
                     const std::string &machine) {
    out << "method,setting,cost_least_ns,cost_median_ns,cost_greatest_ns,error,stable,machine\n";
    for (const ChartPoint &point : chart.points) {
        print(out, "{},{},{:.6g},{:.6g},{:.6g},{},{:d},{}\n", csv_cell(point.method),
              csv_cell(point.setting), point.cost.min_ns, point.cost.median_ns, point.cost.max_ns,
              csv_cell(point.error), point.stable, csv_cell(machine));
    }
}

} // namespace springdrive::charts
