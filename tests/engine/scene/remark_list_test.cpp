#include "engine/scene/remark_list.h"

#include <gtest/gtest.h>

namespace springdrive::scene {
namespace {

using Lines = std::vector<std::string>;

TEST(RemarkList, EqualRemarksOnSeveralThingsAreOneLine) {
    RemarkList remarks;
    remarks.add_of("node 'a'", nullptr, "is left out");
    remarks.add("the scene stands still");
    EXPECT_EQ(remarks.lines(), (Lines{"node 'a': is left out", "the scene stands still"}));
    remarks.add_of("node 7", nullptr, "is left out");
    remarks.add_of("image 'a'", nullptr, "is left out");
    EXPECT_EQ(remarks.lines(), (Lines{"nodes 'a', 7: is left out", "the scene stands still",
                                      "image 'a': is left out"}));
    remarks.add_of("node 'b c'", nullptr, "is left out");
    remarks.add_of("node 'd'", nullptr, "is left out");
    remarks.add_of("node 'e'", nullptr, "is left out");
    EXPECT_EQ(remarks.lines().front(), "nodes 'a', 7, 'b c' and 2 more: is left out");
}

TEST(RemarkList, NumbersAreAddedUp) {
    RemarkList remarks;
    remarks.add_of("node 'a'", nullptr, 3, "points are left out");
    EXPECT_EQ(remarks.lines(), Lines{"node 'a': 3 points are left out"});
    remarks.add_of("node 'b'", nullptr, 4, "points are left out");
    EXPECT_EQ(remarks.lines(), Lines{"nodes 'a', 'b': 7 points are left out"});
}

TEST(RemarkList, PartsOfOneThingCountOnce) {
    RemarkList remarks;
    const int a = 0;
    const int b = 0;
    for (const int *identity : {&a, &a, &b, &b}) {
        remarks.add_of("node 'same'", identity, 1, "points are left out");
    }
    EXPECT_EQ(remarks.lines(), Lines{"nodes 'same', 'same': 4 points are left out"});
}

TEST(RemarkList, TheNumberOfLinesIsBounded) {
    RemarkList remarks;
    for (std::size_t i = 0; i < kMaxRemarkLines; ++i) {
        remarks.add(std::to_string(i));
    }
    EXPECT_EQ(remarks.lines().size(), kMaxRemarkLines);
    EXPECT_EQ(remarks.lines().back(), std::to_string(kMaxRemarkLines - 1));
    remarks.add("one");
    remarks.add("two");
    EXPECT_EQ(remarks.lines().size(), kMaxRemarkLines);
    EXPECT_EQ(remarks.lines().back(), "and 3 more remarks");
}

} // namespace
} // namespace springdrive::scene
