// Covers base/print.h.
#include "base/print.h"

#include <gtest/gtest.h>

#include <sstream>
#include <string>

namespace springdrive {
namespace {

TEST(Print, WritesWhatPrintfWould) {
    std::ostringstream out;
    print(out, "%-6s|%6.2f|%3d|%s", "K_P", 1.005e2, -7, "");
    print(out, "\n");
    EXPECT_EQ(out.str(), "K_P   |100.50| -7|\n");
}

TEST(Print, IsAsLongAsItsText) {
    const std::string text(100'000, 'x');
    std::ostringstream out;
    print(out, "%s.", text.c_str());
    EXPECT_EQ(out.str(), text + ".");
}

} // namespace
} // namespace springdrive
