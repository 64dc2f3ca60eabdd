// Covers engine/lab/charts/chart.cpp.
#include "engine/lab/charts/chart.h"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

namespace springdrive::charts {
namespace {

TEST(ChartCsv, HasARowForEachPoint) {
    SpeedAccuracyChart chart;
    chart.points = {{"one", "100 µs", {1.5, 2.0, 1e6}, 1e-17, true},
                    {"two", "", {0.0, 0.0, 0.0}, NAN, false},
                    {"a, \"b\"", "two\nlines", {1.0, 1.0, 1.0}, INFINITY, false}};
    std::ostringstream out;
    write_csv(out, chart_table(chart, "AMD EPYC (2 cores)"));
    EXPECT_EQ(out.str(),
              "method,setting,cost_least_ns,cost_median_ns,cost_greatest_ns,error,stable,machine\n"
              "one,100 µs,1.5,2,1e+06,1e-17,1,AMD EPYC (2 cores)\n"
              "two,,0,0,0,,0,AMD EPYC (2 cores)\n"
              "\"a, \"\"b\"\"\",\"two\nlines\",1,1,1,,0,AMD EPYC (2 cores)\n");
}

} // namespace
} // namespace springdrive::charts
