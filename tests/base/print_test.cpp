// Covers base/print.h. Formats that must not compile are tested by tests/forbidden_formats.
#include "base/print.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <random>
#include <sstream>
#include <string>

namespace springdrive {
namespace {

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

} // namespace
} // namespace springdrive
