// Covers what of base/strict_toml.cpp the tests of device and tuning files leave: flags, choices,
// lists, rows and the nearest name.
#include "base/strict_toml.h"

#include "tests/support/error_text.h"

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive {
namespace {

constexpr std::array<std::string_view, 3> kColours{"red", "green", "blue"};

StrictTomlTable table_of(const std::string &text) { return StrictTomlTable::parse(text, "t.toml"); }

std::string error(const std::string &text, const std::function<void(StrictTomlTable &)> &read) {
    return testing::error_text_of([&] {
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

} // namespace
} // namespace springdrive
