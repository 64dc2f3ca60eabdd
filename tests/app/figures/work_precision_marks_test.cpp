// Covers app/figures/work_precision_marks.cpp.
#include "app/figures/work_precision_marks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <string>

namespace springdrive {
namespace {

WorkPoint point(const std::string &method, double cost_ns, double error, bool stable = true) {
    return {method, "setting", {0.9 * cost_ns, cost_ns, 2.0 * cost_ns}, error, stable};
}

/// What an assignment gives a name, as text.
std::string value_of(const ChartMarks &marks, const std::string &name) {
    const std::string &all = marks.assignments();
    const std::size_t start = all.find(name + " = ") + name.size() + 3;
    return all.substr(start, all.find("; ", start) - start);
}

double number_of(const ChartMarks &marks, const std::string &name) {
    return std::strtod(value_of(marks, name).c_str(), nullptr);
}

TEST(WorkPrecisionMarks, NumberTheMethodsOfTheRows) {
    WorkPrecisionChart chart;
    chart.points = {point("a, b", 10, 1e-3), point("c", 1e3, 1e-3), point("a, b", 1e5, 1e-6)};
    const ChartMarks marks = work_precision_marks(chart, "note");
    EXPECT_EQ(value_of(marks, "methods"), "'\"a, b\" \"c\" '");
    EXPECT_EQ(value_of(marks, "method_of_rows"), "'1 2 1 '");
    EXPECT_EQ(value_of(marks, "footnote"), "'note'");
}

TEST(WorkPrecisionMarks, RangesHoldEveryPointAndItsSpread) {
    WorkPrecisionChart chart;
    chart.points = {point("a", 10, 1e-3), point("a", 1e3, 1e-5)};
    const ChartMarks marks = work_precision_marks(chart, "");
    EXPECT_LT(number_of(marks, "cost_low_s"), 9e-9);
    EXPECT_GT(number_of(marks, "cost_high_s"), 2e-6);
    EXPECT_LT(number_of(marks, "error_low"), 1e-5);
    EXPECT_GT(number_of(marks, "error_high"), 1e-3);
    EXPECT_EQ(number_of(marks, "error_of_zero"), 0.0);
}

TEST(WorkPrecisionMarks, AnErrorOfZeroStandsBelowAllOthers) {
    WorkPrecisionChart chart;
    chart.points = {point("a", 10, 0.0), point("b", 10, 1e-5), point("c", 10, NAN, false)};
    const ChartMarks marks = work_precision_marks(chart, "");
    EXPECT_LT(number_of(marks, "error_of_zero"), 1e-6);
    EXPECT_GT(number_of(marks, "error_of_zero"), number_of(marks, "error_low"));
    EXPECT_TRUE(std::isfinite(number_of(marks, "error_high")));
}

TEST(WorkPrecisionMarks, HaveRangesWhereNothingIsFinite) {
    WorkPrecisionChart chart;
    chart.points = {point("a", 10, NAN, false), point("a", 10, INFINITY, false)};
    const ChartMarks marks = work_precision_marks(chart, "");
    EXPECT_LT(number_of(marks, "error_low"), number_of(marks, "error_high"));
}

TEST(WorkPrecisionMarks, NameTheEndsOfEachLineButNotOverOneAnother) {
    WorkPrecisionChart chart;
    chart.points = {point("a", 10, 1.0), point("a", 100, 0.1), point("a", 1e4, 1e-3),
                    point("b", 10.1, 0.99), point("b", 1e4, 1e-5)};
    EXPECT_EQ(value_of(work_precision_marks(chart, ""), "named_rows"), "' 0 2 4 '");
}

} // namespace
} // namespace springdrive
