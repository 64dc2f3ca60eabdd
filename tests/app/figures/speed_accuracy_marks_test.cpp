// Covers app/figures/speed_accuracy_marks.cpp.
#include "app/figures/speed_accuracy_marks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app {
namespace {

charts::ChartPoint point(const std::string &method, double cost_ns, double error,
                         bool stable = true) {
    return {method, "setting", {0.9 * cost_ns, cost_ns, 2.0 * cost_ns}, error, stable};
}

/// The value that an assignment gives to a name, as text.
std::string value_of(const ChartMarks &marks, const std::string &name) {
    const std::string &all = marks.assignments();
    const std::size_t start = all.find(name + " = ") + name.size() + 3;
    return all.substr(start, all.find("; ", start) - start);
}

double number_of(const ChartMarks &marks, const std::string &name) {
    return std::strtod(value_of(marks, name).c_str(), nullptr);
}

ChartMarks marks_of(const std::vector<charts::ChartPoint> &points) {
    charts::SpeedAccuracyChart chart;
    chart.points = points;
    return speed_accuracy_marks(chart, "note");
}

TEST(SpeedAccuracyMarks, NumberTheMethodsOfTheRows) {
    const ChartMarks marks =
        marks_of({point("a, b", 10, 1e-3), point("c", 1e3, 1e-3), point("a, b", 1e5, 1e-6)});
    EXPECT_EQ(value_of(marks, "legend"), "'\"a, b: setting\" \"c: setting\" '");
    EXPECT_EQ(value_of(marks, "method_of_rows"), "'1 2 1 '");
    EXPECT_EQ(value_of(marks, "footnote"), "'note'");
}

TEST(SpeedAccuracyMarks, RangesHoldEveryPointAndItsSpread) {
    const ChartMarks marks = marks_of({point("a", 10, 1e-3), point("a", 1e3, 1e-5)});
    EXPECT_LT(number_of(marks, "cost_low_s"), 9e-9);
    EXPECT_GT(number_of(marks, "cost_high_s"), 2e-6);
    EXPECT_LT(number_of(marks, "error_low"), 1e-5);
    EXPECT_GT(number_of(marks, "error_high"), 1e-3);
    EXPECT_EQ(number_of(marks, "error_of_zero"), 0.0);
    EXPECT_EQ(number_of(marks, "has_failures"), 0.0);
    EXPECT_EQ(number_of(marks, "error_of_none"), 0.0);
    const ChartMarks none = marks_of({point("a", 10, NAN, false), point("a", 10, INFINITY, false)});
    EXPECT_LT(number_of(none, "error_low"), number_of(none, "error_high"));
}

TEST(SpeedAccuracyMarks, ErrorsOfZeroAndFailuresWithoutAnErrorStandBeyondAllOthers) {
    const ChartMarks marks =
        marks_of({point("a", 10, 0.0), point("b", 10, 1e-5), point("c", 10, NAN, false)});
    EXPECT_LT(number_of(marks, "error_of_zero"), 1e-6);
    EXPECT_GT(number_of(marks, "error_of_zero"), number_of(marks, "error_low"));
    EXPECT_EQ(number_of(marks, "has_failures"), 1.0);
    EXPECT_GT(number_of(marks, "error_of_none"), 1e-5);
    EXPECT_LT(number_of(marks, "error_of_none"), number_of(marks, "error_high"));
    EXPECT_TRUE(std::isfinite(number_of(marks, "error_high")));
}

TEST(SpeedAccuracyMarks, RoundOffStandsWithZeroAndDoesNotStretchTheAxis) {
    const ChartMarks marks =
        marks_of({point("a", 10, 1e-3), point("a", 100, 1e-6), point("exact", 10, 1.4e-17)});
    EXPECT_GT(number_of(marks, "round_off"), 1.4e-17);
    EXPECT_LT(number_of(marks, "round_off"), 2e-17);
    EXPECT_GT(number_of(marks, "error_low"), 1e-10);
    EXPECT_GT(number_of(marks, "error_of_zero"), number_of(marks, "error_low"));
    // Six decades in steps, as by an integrator's order, are not round-off.
    const ChartMarks steps =
        marks_of({point("a", 10, 1e-3), point("a", 100, 1e-8), point("a", 1000, 1e-13)});
    EXPECT_EQ(number_of(steps, "round_off"), 0.0);
}

TEST(SpeedAccuracyMarks, TheLegendHasTheFirstAndTheLastSettingOfEachMethod) {
    for (const auto &[settings, legend] :
         std::vector<std::pair<std::vector<const char *>, std::string>>{
             {{"1000 µs", "500 µs", "0.9766 µs"}, "1000 … 0.9766 µs"},
             {{"250 Hz", "20 kHz"}, "250 Hz … 20 kHz"},
             {{"α 1000", "α 11000"}, "α 1000 … α 11000"},
             {{"1e-2", "1e-10"}, "1e-2 … 1e-10"},
             {{"exact"}, "exact"}}) {
        std::vector<charts::ChartPoint> points;
        for (const char *setting : settings) {
            points.push_back(point("a", 10, 1.0));
            points.back().setting = setting;
        }
        EXPECT_EQ(value_of(marks_of(points), "legend"), "'\"a: " + legend + "\" '");
    }
}

} // namespace
} // namespace springdrive::app
