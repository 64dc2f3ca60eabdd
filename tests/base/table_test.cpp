// Covers base/table.cpp.
#include "base/table.h"

#include "tests/support/csv.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <sstream>

namespace springdrive {
namespace {

using Lines = std::vector<std::vector<std::string>>;

std::string text_of(void (*write)(std::ostream &, const Table &), const Table &table) {
    std::ostringstream out;
    write(out, table);
    return out.str();
}

TEST(Table, IsReadBackFromCsvByAnotherReader) {
    const Lines texts{{"name", "a, \"b\""},
                      {"two\nlines", "\"\""},
                      {" blanks ", "crlf\r\n"},
                      {"µ·字", "'tis"},
                      {"", ","}};
    Table table{.columns = {{texts[0][0]}, {texts[0][1]}}};
    for (std::size_t i = 1; i < texts.size(); ++i) {
        table.rows.push_back({texts[i][0], texts[i][1]});
    }
    EXPECT_EQ(testing::parsed_csv(text_of(write_csv, table)), texts);
}

TEST(Table, GuardsTextsInCsvButNoNumbers) {
    Table table = Table::with_columns("a,b,c");
    table.rows = {{"=1+1", -1, -0.5}, {"-", -1e-300, "-0.5"}};
    EXPECT_EQ(text_of(write_csv, table), "a,b,c\n'=1+1,-1,-0.5\n'-,-1e-300,-0.5\n");
}

TEST(Table, WritesNumbersWithTheFormatOfTheirColumn) {
    Table table = Table::with_columns("exact:,rounded", ".3g");
    table.rows = {{0.1, 1.0 / 3.0},
                  {1e300, 1},
                  {std::numeric_limits<std::uint64_t>::max(), "text"},
                  {true, std::optional<double>(12345.0)}};
    EXPECT_EQ(text_of(write_csv, table),
              "exact,rounded\n0.1,0.333\n1e+300,1\n18446744073709551615,text\n1,1.23e+04\n");
}

TEST(Table, LeavesWhatIsNotKnownEmpty) {
    Table table = Table::with_columns("a,b,c,d");
    table.rows = {{Cell(), NAN, INFINITY, std::optional<int>()}, {"x", 1, 2.5, std::optional(4)}};
    EXPECT_EQ(text_of(write_csv, table), "a,b,c,d\n,,,\nx,1,2.5,4\n");
    EXPECT_EQ(text_of(write_tsv, table), "a\tb\tc\td\nn/a\tn/a\tn/a\tn/a\nx\t1\t2.5\t4\n");
    EXPECT_EQ(text_of(write_text, table), "a  b    c  d\n–  –    –  –\nx  1  2.5  4\n");
}

TEST(Table, AlignsNumbersAtTheRightAndTextsAtTheLeft) {
    Table table = Table::with_columns("who,force\nN:.2f,K_θ,95 %,remark");
    table.rows = {{"Ω", 1.234, 5, Cell::like_number("1 to 2"), ""},
                  {"longer", -10.0, "none", Cell(), "a remark"}};
    EXPECT_EQ(text_of(write_text, table), "         force\n"
                                          "who          N   K_θ    95 %  remark\n"
                                          "Ω         1.23     5  1 to 2\n"
                                          "longer  -10.00  none       –  a remark\n");
}

TEST(Table, IsADocumentsTable) {
    Table table = Table::with_columns("method,limit:.3g");
    table.rows = {{"|A| > 1", 1234.5}, {"other", Cell()}};
    EXPECT_EQ(text_of(write_markdown, table), "| method | limit |\n"
                                              "| --- | ---: |\n"
                                              "| \\|A\\| > 1 | 1.23e+03 |\n"
                                              "| other | – |\n");
}

} // namespace
} // namespace springdrive
