#include "base/new_file.h"

#include <gtest/gtest.h>

#include <ctime>
#include <set>

namespace springdrive {
namespace {

TEST(FileNames, CountOnWhereOneIsTaken) {
    std::set<std::filesystem::path> taken;
    for (const char *expected : {"plots.csv", "plots-2.csv", "plots-3.csv"}) {
        const std::filesystem::path name = unused_name(
            "plots.csv", [&](const std::filesystem::path &some) { return taken.contains(some); });
        EXPECT_EQ(name, expected);
        taken.insert(name);
    }
}

TEST(FileNames, HaveTheirNumberBeforeTheEnding) {
    EXPECT_EQ(numbered_name("a/touch.rec", 1), "a/touch.rec");
    EXPECT_EQ(numbered_name("a/touch.rec", 2), "a/touch-2.rec");
    EXPECT_EQ(numbered_name("touch", 10), "touch-10");
    EXPECT_EQ(numbered_name("a.b/x.y.rec", 3), "a.b/x.y-3.rec");
}

TEST(FileNames, HoldTheLocalTime) {
    const std::time_t before = std::time(nullptr);
    const std::string name = dated_name("a stem");
    std::tm parts{};
    ASSERT_EQ(name.substr(0, 7), "a stem-");
    const char *const end = strptime(name.c_str() + 7, "%Y%m%d-%H%M%S", &parts);
    ASSERT_NE(end, nullptr);
    EXPECT_EQ(*end, '\0');
    parts.tm_isdst = -1;
    EXPECT_LE(std::difftime(std::mktime(&parts), before), 2.0);
    EXPECT_GE(std::difftime(std::mktime(&parts), before), 0.0);
}

} // namespace
} // namespace springdrive
