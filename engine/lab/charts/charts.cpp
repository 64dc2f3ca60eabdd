#include "engine/lab/charts/charts.h"

namespace springdrive::charts {

Table chart_table(const SpeedAccuracyChart &chart, const std::string &machine) {
    Table table = Table::with_columns("method,setting,cost_least_ns:.6g,cost_median_ns:.6g,"
                                      "cost_greatest_ns:.6g,error,stable,machine");
    for (const ChartPoint &point : chart.points) {
        table.rows.push_back({point.method, point.setting, point.cost.min_ns, point.cost.median_ns,
                              point.cost.max_ns, point.error, point.stable, machine});
    }
    return table;
}

} // namespace springdrive::charts
