// Covers base/one_line.h, base/print.h and base/machine_name.cpp. Formats that must not compile are
// tested by tests/forbidden_formats.
#include "base/one_line.h"

#include "base/machine_name.h"
#include "base/print.h"

#include <gtest/gtest.h>

#include <array>
#include <sstream>
#include <string>

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

} // namespace
} // namespace springdrive
