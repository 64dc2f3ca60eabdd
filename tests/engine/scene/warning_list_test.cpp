#include "engine/scene/warning_list.h"

#include <gtest/gtest.h>

namespace springdrive::scene {
namespace {

using Lines = std::vector<std::string>;

TEST(WarningList, EqualWarningsOnSeveralThingsAreOneLine) {
    WarningList warnings;
    warnings.add_of("node 'a'", nullptr, "is left out");
    warnings.add("the scene stands still");
    EXPECT_EQ(warnings.lines(), (Lines{"node 'a': is left out", "the scene stands still"}));
    warnings.add_of("node 7", nullptr, "is left out");
    warnings.add_of("image 'a'", nullptr, "is left out");
    EXPECT_EQ(warnings.lines(), (Lines{"nodes 'a', 7: is left out", "the scene stands still",
                                       "image 'a': is left out"}));
    warnings.add_of("node 'b c'", nullptr, "is left out");
    warnings.add_of("node 'd'", nullptr, "is left out");
    warnings.add_of("node 'e'", nullptr, "is left out");
    EXPECT_EQ(warnings.lines().front(), "nodes 'a', 7, 'b c' and 2 more: is left out");
}

TEST(WarningList, NumbersAreAddedUp) {
    WarningList warnings;
    warnings.add_of("node 'a'", nullptr, 3, "points are left out");
    EXPECT_EQ(warnings.lines(), Lines{"node 'a': 3 points are left out"});
    warnings.add_of("node 'b'", nullptr, 4, "points are left out");
    EXPECT_EQ(warnings.lines(), Lines{"nodes 'a', 'b': 7 points are left out"});
}

TEST(WarningList, PartsOfOneThingCountOnce) {
    WarningList warnings;
    const int a = 0;
    const int b = 0;
    for (const int *identity : {&a, &a, &b, &b}) {
        warnings.add_of("node 'same'", identity, 1, "points are left out");
    }
    EXPECT_EQ(warnings.lines(), Lines{"nodes 'same', 'same': 4 points are left out"});
}

TEST(WarningList, TheNumberOfLinesIsBounded) {
    WarningList warnings;
    for (std::size_t i = 0; i < kMaxWarningLines; ++i) {
        warnings.add(std::to_string(i));
    }
    EXPECT_EQ(warnings.lines().size(), kMaxWarningLines);
    EXPECT_EQ(warnings.lines().back(), std::to_string(kMaxWarningLines - 1));
    warnings.add("one");
    warnings.add("two");
    EXPECT_EQ(warnings.lines().size(), kMaxWarningLines);
    EXPECT_EQ(warnings.lines().back(), "and 3 more remarks");
}

} // namespace
} // namespace springdrive::scene
