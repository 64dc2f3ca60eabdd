// Covers base/print.h. Formats that must not compile are tested by tests/forbidden_formats.
#include "base/print.h"

#include <gtest/gtest.h>

#include <array>
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

} // namespace
} // namespace springdrive
