// Covers base/formula_guard.cpp.
#include "base/formula_guard.h"

#include "base/print.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace springdrive {
namespace {

TEST(FormulaGuard, LetsNoTextBeginLikeAFormula) {
    for (const auto &[text, guarded] : std::vector<std::pair<std::string, std::string>>{
             {"=1+1", "'=1+1"},
             {"=HYPERLINK(\"http://x\")", "'=HYPERLINK(\"http://x\")"},
             {"+49 30 1234", "'+49 30 1234"},
             {"-", "'-"},
             {"-2 to 3", "'-2 to 3"},
             {"@SUM(A1)", "'@SUM(A1)"},
             {"\t=1", "'\t=1"},
             {"\r=1", "'\r=1"},
             {"＝1+1", "'＝1+1"},
             {"'=1", "''=1"},
             {"'-5", "''-5"}}) {
        EXPECT_EQ(guard_formula(text), guarded);
        EXPECT_EQ(unguard_formula(guarded), text);
    }
}

TEST(FormulaGuard, LeavesNumbersAndOrdinaryTextsAsTheyAre) {
    for (const std::string text : {"", "-5", "-0", "-1e-300", "-inf", "-1e999", "5", "a=b", "'",
                                   "'tis", "a - b", "n/a", "ä"}) {
        EXPECT_EQ(guard_formula(text), text);
        EXPECT_EQ(unguard_formula(text), text);
    }
}

TEST(FormulaGuard, IsInEachCellOfACsvFile) {
    EXPECT_EQ(csv_cell("=1,2"), "\"'=1,2\"");
    EXPECT_EQ(csv_cell("\r=1"), "\"'\r=1\"");
    EXPECT_EQ(csv_cell(-0.5), "-0.5");
    EXPECT_EQ(csv_cell("-0.5"), "-0.5");
}

} // namespace
} // namespace springdrive
