// Covers app/figures/speed_accuracy_marks.cpp.
#include "app/figures/speed_accuracy_marks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <string>
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

TEST(SpeedAccuracyMarks, NumberTheMethodsOfTheRows) {
    charts::SpeedAccuracyChart chart;
    chart.points = {point("a, b", 10, 1e-3), point("c", 1e3, 1e-3), point("a, b", 1e5, 1e-6)};
    const ChartMarks marks = speed_accuracy_marks(chart, "note");
    EXPECT_EQ(value_of(marks, "legend"), "'\"a, b: setting\" \"c: setting\" '");
    EXPECT_EQ(value_of(marks, "method_of_rows"), "'1 2 1 '");
    EXPECT_EQ(value_of(marks, "footnote"), "'note'");
}

TEST(SpeedAccuracyMarks, RangesHoldEveryPointAndItsSpread) {
    charts::SpeedAccuracyChart chart;
    chart.points = {point("a", 10, 1e-3), point("a", 1e3, 1e-5)};
    const ChartMarks marks = speed_accuracy_marks(chart, "");
    EXPECT_LT(number_of(marks, "cost_low_s"), 9e-9);
    EXPECT_GT(number_of(marks, "cost_high_s"), 2e-6);
    EXPECT_LT(number_of(marks, "error_low"), 1e-5);
    EXPECT_GT(number_of(marks, "error_high"), 1e-3);
    EXPECT_EQ(number_of(marks, "error_of_zero"), 0.0);
}

TEST(SpeedAccuracyMarks, AnErrorOfZeroStandsBelowAllOthers) {
    charts::SpeedAccuracyChart chart;
    chart.points = {point("a", 10, 0.0), point("b", 10, 1e-5), point("c", 10, NAN, false)};
    const ChartMarks marks = speed_accuracy_marks(chart, "");
    EXPECT_LT(number_of(marks, "error_of_zero"), 1e-6);
    EXPECT_GT(number_of(marks, "error_of_zero"), number_of(marks, "error_low"));
    EXPECT_TRUE(std::isfinite(number_of(marks, "error_high")));
}

TEST(SpeedAccuracyMarks, HaveRangesWhereNothingIsFinite) {
    charts::SpeedAccuracyChart chart;
    chart.points = {point("a", 10, NAN, false), point("a", 10, INFINITY, false)};
    const ChartMarks marks = speed_accuracy_marks(chart, "");
    EXPECT_LT(number_of(marks, "error_low"), number_of(marks, "error_high"));
}

TEST(SpeedAccuracyMarks, RoundOffStandsWithZeroAndDoesNotStretchTheAxis) {
    charts::SpeedAccuracyChart chart;
    chart.points = {point("a", 10, 1e-3), point("a", 100, 1e-6), point("exact", 10, 1.4e-17)};
    const ChartMarks marks = speed_accuracy_marks(chart, "");
    EXPECT_GT(number_of(marks, "round_off"), 1.4e-17);
    EXPECT_LT(number_of(marks, "round_off"), 2e-17);
    EXPECT_GT(number_of(marks, "error_low"), 1e-10);
    EXPECT_GT(number_of(marks, "error_of_zero"), number_of(marks, "error_low"));
    // Six decades in steps, as by an integrator's order, are not round-off.
    chart.points = {point("a", 10, 1e-3), point("a", 100, 1e-8), point("a", 1000, 1e-13)};
    EXPECT_EQ(number_of(speed_accuracy_marks(chart, ""), "round_off"), 0.0);
}

TEST(SpeedAccuracyMarks, AFailureWithoutAnErrorStandsAboveAll) {
    charts::SpeedAccuracyChart chart;
    chart.points = {point("a", 10, 1e-3), point("a", 100, NAN, false)};
    const ChartMarks marks = speed_accuracy_marks(chart, "");
    EXPECT_EQ(number_of(marks, "has_failures"), 1.0);
    EXPECT_GT(number_of(marks, "error_of_none"), 1e-3);
    EXPECT_LT(number_of(marks, "error_of_none"), number_of(marks, "error_high"));
    chart.points.pop_back();
    const ChartMarks well = speed_accuracy_marks(chart, "");
    EXPECT_EQ(number_of(well, "has_failures"), 0.0);
    EXPECT_EQ(number_of(well, "error_of_none"), 0.0);
}

TEST(SpeedAccuracyMarks, TheLegendHasTheFirstAndTheLastSettingOfEachMethod) {
    charts::SpeedAccuracyChart chart;
    const auto legend_of = [&](const std::vector<std::string> &settings) {
        chart.points.clear();
        for (const std::string &setting : settings) {
            chart.points.push_back(point("a", 10, 1.0));
            chart.points.back().setting = setting;
        }
        return value_of(speed_accuracy_marks(chart, ""), "legend");
    };
    EXPECT_EQ(legend_of({"1000 µs", "500 µs", "0.9766 µs"}), "'\"a: 1000 … 0.9766 µs\" '");
    EXPECT_EQ(legend_of({"250 Hz", "20 kHz"}), "'\"a: 250 Hz … 20 kHz\" '");
    EXPECT_EQ(legend_of({"α 1000", "α 11000"}), "'\"a: α 1000 … α 11000\" '");
    EXPECT_EQ(legend_of({"1e-2", "1e-10"}), "'\"a: 1e-2 … 1e-10\" '");
    EXPECT_EQ(legend_of({"exact"}), "'\"a: exact\" '");
}

} // namespace
} // namespace springdrive::app
