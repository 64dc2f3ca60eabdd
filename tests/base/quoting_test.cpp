// Covers base/text.cpp.
#include "base/text.h"

#include "base/strict_toml.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
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
    }
}

TEST(FormulaGuard, LeavesNumbersAndOrdinaryTextsAsTheyAre) {
    for (const std::string text : {"", "-5", "-0", "-1e-300", "-inf", "-1e999", "5", "a=b", "'",
                                   "'tis", "a - b", "n/a", "ä"}) {
        EXPECT_EQ(guard_formula(text), text);
    }
}

TEST(FormulaGuard, IsInEachCellOfACsvFile) {
    EXPECT_EQ(csv_cell("=1,2"), "\"'=1,2\"");
    EXPECT_EQ(csv_cell("\r=1"), "\"'\r=1\"");
    EXPECT_EQ(csv_cell(-0.5), "-0.5");
    EXPECT_EQ(csv_cell("-0.5"), "-0.5");
}

TEST(CsvCell, IsQuotedIfNeeded) {
    EXPECT_EQ(csv_cell("100 µs"), "100 µs");
    EXPECT_EQ(csv_cell("a, \"b\""), "\"a, \"\"b\"\"\"");
    EXPECT_EQ(csv_cell("two\nlines"), "\"two\nlines\"");
    EXPECT_EQ(csv_cell(""), "");
}

TEST(CsvCell, OfANumberReadsBackAsTheSameNumber) {
    std::mt19937_64 random(1);
    for (int trial = 0; trial < 1000; ++trial) {
        const auto number = std::bit_cast<double>(random());
        if (std::isfinite(number)) {
            EXPECT_EQ(std::strtod(csv_cell(number).c_str(), nullptr), number);
        }
    }
    EXPECT_EQ(csv_cell(0.1), "0.1");
    EXPECT_EQ(csv_cell(INFINITY), "");
    EXPECT_EQ(csv_cell(NAN), "");
}

TEST(TsvCell, IsOnOneLineAndNeverEmpty) {
    EXPECT_EQ(tsv_cell("a\t\"b\"\nc"), "\"a \"\"b\"\" c\"");
    EXPECT_EQ(tsv_cell("=1"), "'=1");
    EXPECT_EQ(tsv_cell("a, b"), "a, b");
    EXPECT_EQ(tsv_cell(""), "n/a");
}

TEST(GnuplotString, IsReadBackByGnuplot) {
    const std::string text = "it's \\n {x}_1 %g `ls` $x\n\"q\" µ";
    EXPECT_EQ(gnuplot_string("it's\n"), "'it''s '");
    const std::filesystem::path script = testing::fresh_folder("gnuplot_string") / "script";
    std::ofstream(script) << "set print '-'\nprint " << gnuplot_string(text) << '\n';
    FILE *const gnuplot = popen(("gnuplot " + script.string() + " 2>&1").c_str(), "r");
    ASSERT_NE(gnuplot, nullptr);
    std::string printed;
    for (int c = fgetc(gnuplot); c != EOF; c = fgetc(gnuplot)) {
        printed += static_cast<char>(c);
    }
    if (pclose(gnuplot) != 0) {
        GTEST_SKIP() << printed; // it is not installed
    }
    EXPECT_EQ(printed, "it's \\n {x}_1 %g `ls` $x \"q\" µ\n");
}

TEST(TomlText, IsReadBackAsItWas) {
    const std::string all = "a \"b\" \\ 'c' # = [µ]\n\t\x01\x7f";
    StrictTomlTable table = StrictTomlTable::parse(
        "texts = " + toml_list(std::vector{all, std::string()}) + "\nnumber = " + toml_number(3.0) +
            "\nsmall = " + toml_number(-1e-300),
        "t.toml");
    EXPECT_EQ(table.texts("texts", 2), (std::vector<std::string>{all, ""}));
    EXPECT_EQ(table.number("number"), 3.0);
    EXPECT_EQ(table.number("small"), -1e-300);
    EXPECT_EQ(toml_number(3.0), "3.0"); // another reader would take 3 for an integer
}

TEST(XmlText, HasNoTagsNorCharactersThatXmlForbids) {
    EXPECT_EQ(xml_text("a < b & \"c\" > d\x01\tµ"), "a &lt; b &amp; \"c\" &gt; d\tµ");
}

} // namespace
} // namespace springdrive
