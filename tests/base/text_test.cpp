// Covers texts: base/text.cpp, base/print.h, base/timing.cpp, base/table.cpp, and what of
// base/strict_toml.cpp the tests of device and tuning files leave: flags, choices, lists, rows and
// the nearest name. Formats that must not compile are tested by tests/forbidden_formats.
#include "base/text.h"

#include "base/for_persons.h"
#include "base/input_error.h"
#include "base/print.h"
#include "base/strict_toml.h"
#include "base/table.h"
#include "base/timing.h"
#include "tests/support/csv.h"
#include "tests/support/files.h"
#include "tests/support/names.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace springdrive {
namespace {

TEST(OneLine, OneLineHasNoControlCharacters) {
    EXPECT_EQ(one_line("  a\n\tb\x1b[31m \r\n c \n"), "a b [31m c");
    EXPECT_EQ(one_line(""), "");
    EXPECT_EQ(one_line("\n\n"), "");
}

TEST(OneLine, LongTextIsCutButNotWithinACharacter) {
    EXPECT_EQ(one_line("abcdef", 6), "abcdef");
    EXPECT_EQ(one_line("abcdefg", 6), "abcdef...");
    // "ä" is two bytes; cutting after five bytes would halve the third.
    EXPECT_EQ(one_line("\u00e4\u00e4\u00e4\u00e4", 5), "\u00e4\u00e4...");
}

TEST(OneLine, ShortestNumberReadsBackAsItself) {
    EXPECT_EQ(shortest_text(0.1), "0.1");
    EXPECT_EQ(shortest_text(-3.0), "-3");
    EXPECT_EQ(shortest_text(1e300), "1e+300");
}

TEST(Print, WritesColumns) {
    std::ostringstream out;
    print(out, "{:<6}|{:>6.2f}|{:>3}|{}", "K_P", 1.005e2, -7, "");
    print(out, "\n");
    EXPECT_EQ(out.str(), "K_P   |100.50| -7|\n");
}

TEST(Print, CountsCharactersOfAColumnNotBytes) {
    std::ostringstream out;
    print(out, "{:<4}|{:>4}|", "Ω", "µm");
    EXPECT_EQ(out.str(), "Ω   |  µm|");
}

TEST(Print, TakesItsWidthAndPrecisionFromValues) {
    std::ostringstream out;
    print(out, "{:>{}.{}f}{{}}", 2.0, 8, 3);
    EXPECT_EQ(out.str(), "   2.000{}");
}

TEST(Print, IsAsLongAsItsText) {
    const std::string text(100'000, 'x');
    std::ostringstream out;
    print(out, "{}.", text);
    EXPECT_EQ(out.str(), text + ".");
}

TEST(Print, IntoABufferEndsWithTheBuffer) {
    std::array<char, 8> text{};
    text.fill('#');
    print(text, "{} {}", 1.5, "N");
    EXPECT_STREQ(text.data(), "1.5 N");
    print(text, "{}", 1234567);
    EXPECT_STREQ(text.data(), "1234567");
    print(text, "{}", 123456789);
    EXPECT_STREQ(text.data(), "1234567");
}

TEST(MachineName, IsTheFirstModelThatCpuinfoNames) {
    std::istringstream two("processor\t: 0\nmodel\t\t: 17\nmodel name\t: Fast: one\n"
                           "model name\t: Slow one\n");
    EXPECT_EQ(processor_model(two), "Fast: one");
}

TEST(MachineName, MayBeUnknown) {
    std::istringstream nothing("");
    EXPECT_EQ(processor_model(nothing), "unknown processor");
    std::istringstream other("Hardware : board\nmodel name\t: \nmodel name");
    EXPECT_EQ(processor_model(other), "unknown processor");
}

TEST(MachineName, EndsWithTheCores) {
    EXPECT_NE(machine_name().find(" core"), std::string::npos);
    EXPECT_EQ(machine_name().back(), ')');
}

/// A letter in the forms that Unicode takes for one: whole, and in parts; and in the other case.
struct Forms {
    std::string whole;
    std::string in_parts;
    std::string other_case;
};

const std::vector<Forms> kLetters{{"a", "a", "A"},
                                  {"0", "0", "0"},
                                  {"-", "-", "-"},
                                  {"\u00e9", "e\u0301", "\u00c9"},
                                  {"\u00e5", "a\u030a", "A\u030a"},
                                  {"\u1ec7", "e\u0323\u0302", "\u1ec6"}, // its third form is below
                                  {"\u03bb", "\u03bb", "\u039b"},
                                  {"\u03ac", "\u03b1\u0301", "\u0386"},
                                  {"\u0439", "\u0438\u0306", "\u0419"},
                                  {"\u0434", "\u0434", "\u0414"},
                                  {"\u304c", "\u304b\u3099", "\u304c"},
                                  {"\uac00", "\u1100\u1161", "\uac00"},
                                  {"\u5b57", "\u5b57", "\u5b57"},
                                  {"\U0001f600", "\U0001f600", "\U0001f600"}};

TEST(LookAlike, AreNamesThatPersonsTakeForOne) {
    const std::vector<std::string> unseen{" ",      "\t",     "\u00a0", "\u2009", "\u200b",
                                          "\u00ad", "\ufeff", "\u3000", "\u202f"};
    std::mt19937_64 random(50);
    const auto below = [&random](std::size_t limit) { return random() % limit; };
    for (int i = 0; i < 2000; ++i) {
        std::vector<std::size_t> letters(1 + below(12));
        std::ranges::generate(letters, [&] { return below(kLetters.size()); });
        const auto written = [&](const std::vector<std::size_t> &of) {
            std::string name;
            for (const std::size_t letter : of) {
                name += below(5) == 0 ? unseen[below(unseen.size())] : "";
                const Forms &forms = kLetters[letter];
                name += std::array{forms.whole, forms.in_parts, forms.other_case}[below(3)];
            }
            return name;
        };
        const std::string name = written(letters);
        EXPECT_TRUE(look_alike(name, written(letters))) << name;
        // Another letter, one fewer, or one more. Letters that are whole and not ASCII are like any
        // in parts, so that only the plain ones tell.
        std::vector<std::size_t> other = letters;
        const std::size_t at = below(other.size());
        std::string cut = name + "b";
        EXPECT_FALSE(look_alike(name, cut)) << name << " | " << cut;
        other.insert(other.begin() + static_cast<std::ptrdiff_t>(at), below(2));
        EXPECT_FALSE(look_alike(name, written(other))) << name;
        if (letters[at] < 2) {
            letters[at] = 1 - letters[at];
            EXPECT_FALSE(look_alike(name, written(letters))) << name;
        }
    }
    EXPECT_TRUE(look_alike("\u00ea\u0323", "e\u0323\u0302"));
    EXPECT_FALSE(look_alike("e\u0301", "e"));
    EXPECT_FALSE(look_alike("\u00e9", "\u00e8"));
    EXPECT_FALSE(look_alike("0.5", "0.05"));
    EXPECT_TRUE(look_alike("", " \u200b"));
    EXPECT_TRUE(look_alike("\xff", "\xff")) << "no UTF-8, but no harm";
}

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
    EXPECT_EQ(tsv_cell("a,  b"), "a,  b");
    EXPECT_EQ(tsv_cell("\t=1 "), "'=1");
    EXPECT_EQ(tsv_cell(" \n"), "n/a");
    EXPECT_EQ(tsv_cell(""), "n/a");
}

/// What gnuplot prints of texts, a line each; nothing where it is not installed.
std::optional<std::string> printed_by_gnuplot(const std::vector<std::string> &texts) {
    const std::filesystem::path script = testing::fresh_folder("gnuplot_string") / "script";
    {
        std::ofstream file(script);
        file << "set print '-'\n";
        for (const std::string &text : texts) {
            file << "print " << gnuplot_string(text) << '\n';
        }
    }
    FILE *const gnuplot = popen(("gnuplot " + script.string() + " 2>&1").c_str(), "r");
    std::string printed;
    for (int c = fgetc(gnuplot); c != EOF; c = fgetc(gnuplot)) {
        printed += static_cast<char>(c);
    }
    return pclose(gnuplot) == 0 ? std::optional(printed) : std::nullopt;
}

TEST(GnuplotString, IsReadBackByGnuplot) {
    EXPECT_EQ(gnuplot_string("it's\n"), "'it''s '");
    EXPECT_EQ(gnuplot_string("\x1b\r\ufffe\uffff\ufffd\u00bf"), "'  \ufffd\ufffd\ufffd\u00bf'");
    const auto printed = printed_by_gnuplot({"it's \\n {x}_1 %g `ls` $x\n\"q\" µ"});
    if (!printed) {
        GTEST_SKIP() << "gnuplot is not installed";
    }
    EXPECT_EQ(*printed, "it's \\n {x}_1 %g `ls` $x \"q\" µ\n");
}

/// A cell as a reader has it that knows RFC 4180 with this separator.
std::string read_cell(const std::string &cell, char separator) {
    const auto lines = testing::parsed_csv("a" + std::string(1, separator) + cell + "\n");
    EXPECT_EQ(lines.size(), 1U) << cell;
    if (separator == ',') {
        EXPECT_EQ(lines[0].size(), 2U) << cell;
        return lines[0].back();
    }
    EXPECT_EQ(cell.find('\t'), std::string::npos);
    return cell.front() != '"' ? cell : testing::parsed_csv(cell + "\n")[0][0];
}

TEST(Name, OfAnyCharactersIsReadBackFromEachLanguage) {
    std::mt19937_64 random(50);
    std::vector<std::string> names;
    std::string lines;
    for (int i = 0; i < 500; ++i) {
        std::string &name =
            names.emplace_back(testing::random_name(random).substr(i % 2 == 0 ? 0 : 1));
        name.erase(0, name.find_first_not_of(' '));
        lines += name + '\n';
        EXPECT_EQ(read_cell(csv_cell(name), ','), guard_formula(name));
        EXPECT_EQ(read_cell(tsv_cell(name), '\t'), guard_formula(name));
        EXPECT_EQ(nlohmann::json::parse(json_text(nlohmann::json(name))), name);
        EXPECT_EQ(testing::texts_of_svg("<text>" + xml_text(name) + "</text>"), name);
        EXPECT_EQ(as_utf8(name), name);
    }
    StrictTomlTable table = StrictTomlTable::parse("names = " + toml_list(names), "t.toml");
    EXPECT_EQ(table.texts("names", names.size()), names);
    const auto printed = printed_by_gnuplot(names);
    EXPECT_EQ(printed.value_or(lines), lines);
}

TEST(Name, IsRefusedWhereNobodySeesWhatItHas) {
    std::mt19937_64 random(51);
    for (int i = 0; i < 500; ++i) {
        const std::string name = testing::random_name(random);
        EXPECT_EQ(validate_name(name), "") << name;
        for (const char *const unseen : {" ", "\u00a0", "\u00ad", "\u2003", "\u200b", "\u200e",
                                         "\u202e", "\u2060", "\u3000", "\ufeff"}) {
            EXPECT_NE(validate_name(name + unseen).find("ends"), std::string::npos) << name;
            EXPECT_NE(validate_name(unseen + name).find("begins"), std::string::npos) << name;
        }
        for (const char *const control :
             {"\n", "\t", "\r", "\x7f", "\x1b", "\u0085", "\u2028", "\u2029"}) {
            EXPECT_NE(validate_name(name + control + name).find("control"), std::string::npos);
        }
    }
    for (const char *const name :
         {"a", "ä", "\u2010", "\u2030", "\u00a1", "\u00ae", "\U0001F590"}) {
        EXPECT_EQ(validate_name(name), "") << name;
    }
    EXPECT_EQ(in_quotes(" a  b\t"), "' a  b '");
}

TEST(Utf8, ShowsEachByteThatIsNone) {
    EXPECT_EQ(as_utf8("a\xff\xc3ä"), "a\\xff\\xc3ä");
    EXPECT_EQ(as_utf8("\xe2\x80"), "\\xe2\\x80");
    EXPECT_EQ(as_utf8("a  b\n\x7f"), "a  b\\x0a\\x7f");
    std::mt19937_64 random(52);
    for (int i = 0; i < 1000; ++i) {
        std::string bytes;
        for (std::size_t left = random() % 12; left > 0; --left) {
            bytes += static_cast<char>(random());
        }
        const bool has_control =
            std::ranges::any_of(bytes, [](char c) { return (c >= 0 && c < ' ') || c == '\x7f'; });
        EXPECT_TRUE(is_utf8(as_utf8(bytes)));
        EXPECT_EQ(as_utf8(bytes) == bytes, is_utf8(bytes) && !has_control);
    }
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
    EXPECT_EQ(xml_text("a < b & \"c\" > d\x01\tµ\uffff"), "a &lt; b &amp; \"c\" &gt; d\tµ\ufffd");
}

constexpr std::array<std::string_view, 3> kColours{"red", "green", "blue"};

StrictTomlTable table_of(const std::string &text) { return StrictTomlTable::parse(text, "t.toml"); }

std::string error(const std::string &text, const std::function<void(StrictTomlTable &)> &read) {
    return error_text_of([&] {
        StrictTomlTable table = table_of(text);
        read(table);
    });
}

TEST(StrictToml, ReadsFlagsChoicesAndLists) {
    StrictTomlTable table = table_of("a = true\nb = 'blue'\nc = [1, 2.5]\nd = ['x', 'y']\n"
                                     "e = ['blue', 'red']\nf = []");
    EXPECT_TRUE(table.flag("a"));
    EXPECT_EQ(table.choice("b", kColours), 2U);
    EXPECT_EQ(table.numbers("c", {0.0, 3.0}, 2), (std::vector{1.0, 2.5}));
    EXPECT_EQ(table.texts("d", 2), (std::vector<std::string>{"x", "y"}));
    EXPECT_EQ(table.choices("e", kColours), (std::vector<std::size_t>{2, 0}));
    EXPECT_TRUE(table.choices("f", kColours).empty());
    table.refuse_unknown_keys();
}

TEST(StrictToml, RefusesWhatIsNone) {
    const auto flag = [](StrictTomlTable &t) { static_cast<void>(t.flag("a")); };
    EXPECT_EQ(error("a = 1", flag), "t.toml:1: a is 1; it must be true or false");
    EXPECT_EQ(error("b = 1", flag), "t.toml:1: a is missing; it must be true or false");
    const auto choice = [](StrictTomlTable &t) { static_cast<void>(t.choice("a", kColours)); };
    EXPECT_EQ(error("\na = \"pink\"", choice),
              "t.toml:2: a is \"pink\"; it must be red, green or blue");
    EXPECT_EQ(error("a = 3", choice), "t.toml:1: a is 3; it must be red, green or blue");
    const auto numbers = [](StrictTomlTable &t) {
        static_cast<void>(t.numbers("a", {0.0, 3.0}, 2));
    };
    EXPECT_EQ(
        error("a = [1, 4]", numbers),
        "t.toml:1: a has 4; it must be 1 to 2 numbers in brackets, each a number from 0 to 3");
    for (const char *text : {"a = []", "a = [1, 2, 3]", "a = 1", "a = ['x']", "a = [nan]", ""}) {
        EXPECT_NE(error(text, numbers), "") << text;
    }
    const auto choices = [](StrictTomlTable &t) { static_cast<void>(t.choices("a", kColours)); };
    EXPECT_EQ(error("a = ['red',\n 'pink']", choices),
              "t.toml:1: a has 'pink'; it must be a list, each of it red, green or blue");
    for (const char *text : {"a = 'red'", "a = [1]", ""}) {
        EXPECT_NE(error(text, choices), "") << text;
    }
    const auto texts = [](StrictTomlTable &t) { static_cast<void>(t.texts("a", 2)); };
    for (const char *text : {"a = []", "a = ['x', 'y', 'z']", "a = 'x'", "a = ['x', 1]", ""}) {
        EXPECT_NE(error(text, texts), "") << text;
    }
}

TEST(StrictToml, ReadsRowsUpToALimit) {
    const std::string two = "[[r]]\nx = 1\n[[r]]\nx = 2\n";
    StrictTomlTable table = table_of(two);
    std::vector<double> seen;
    table.rows("r", 2, [&seen](StrictTomlTable &row) { seen.push_back(row.number("x")); });
    EXPECT_EQ(seen, (std::vector{1.0, 2.0}));
    const auto rows = [](StrictTomlTable &t) {
        t.rows("r", 1, [](StrictTomlTable &row) { row.refuse_unknown_keys(); });
    };
    EXPECT_EQ(error(two, rows), "t.toml:1: r appears 2 times; it must appear 1 to 1 times");
    EXPECT_EQ(error("", rows), "t.toml:1: r is missing; add a table [[r]]");
    EXPECT_NE(error("r = [1]", rows), "");
    EXPECT_NE(error("r = {x = 1}", rows), "");
    EXPECT_EQ(error("[[r]]\nx = 1", rows).substr(0, 30), "t.toml:2: r[1].x is not known;");
}

TEST(StrictToml, NamesTheNearestKeyThatItKnows) {
    const auto read = [](StrictTomlTable &t) {
        static_cast<void>(t.has_optional("height_m"));
        static_cast<void>(t.has_optional("width_m"));
        t.refuse_unknown_keys();
    };
    EXPECT_EQ(error("hieght_m = 1", read),
              "t.toml:1: hieght_m is not known; the nearest is height_m; the known keys are "
              "height_m, width_m");
    EXPECT_EQ(error("width_m = 1", read), "");
}

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

TEST(Table, HasAByteOrderMarkForPersonsIfItNeedsOne) {
    Table table = Table::with_columns("name,n");
    table.rows = {{"plain", 1}};
    EXPECT_EQ(text_of(write_csv_for_persons, table), text_of(write_csv, table));
    table.rows.push_back({"Größe", 2});
    EXPECT_EQ(text_of(write_csv_for_persons, table), "\xEF\xBB\xBF" + text_of(write_csv, table));
    EXPECT_TRUE(text_of(write_csv, table).starts_with("name,n\n")) << "for programs, none";
    EXPECT_TRUE(text_of(write_tsv, table).starts_with("name\tn\n")) << "BIDS has none";
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
