#include "base/text.h"

#include <gtest/gtest.h>

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

} // namespace
} // namespace springdrive
