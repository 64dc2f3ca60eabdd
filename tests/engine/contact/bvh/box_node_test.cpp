// Covers engine/contact/bvh/box_node.h.
#include "engine/contact/bvh/box_node.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace springdrive::contact {
namespace {

TEST(Float4, LaneBitsAreTheHighestBitsOfTheLanes) {
    for (unsigned bits = 0; bits < 16; ++bits) {
        Mask4 all_or_none{};
        Mask4 highest_or_others{};
        for (int lane = 0; lane < 4; ++lane) {
            const bool is_set = (bits >> static_cast<unsigned>(lane) & 1U) != 0;
            all_or_none[lane] = is_set ? -1 : 0;
            highest_or_others[lane] = is_set ? std::numeric_limits<std::int32_t>::min()
                                             : std::numeric_limits<std::int32_t>::max();
        }
        for (const Mask4 mask : {all_or_none, highest_or_others}) {
            EXPECT_EQ(lane_bits(mask), bits);
            EXPECT_EQ(lane_bits_portably(mask), bits);
        }
    }
}

TEST(Float4, SmallerAndLargerTakeTheSecondWhereOneIsNotANumber) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const Float4 a{1.0F, -2.0F, NAN, 4.0F};
    const Float4 b{2.0F, -kInfinity, 3.0F, NAN};
    const Float4 smallest = smaller(a, b);
    const Float4 largest = larger(a, b);
    const Float4 smallest_portably = smaller_portably(a, b);
    const Float4 largest_portably = larger_portably(a, b);
    for (const Float4 &minimum : {smallest, smallest_portably}) {
        EXPECT_EQ(minimum[0], 1.0F);
        EXPECT_EQ(minimum[1], -kInfinity);
        EXPECT_EQ(minimum[2], 3.0F);
        EXPECT_TRUE(std::isnan(minimum[3]));
    }
    for (const Float4 &maximum : {largest, largest_portably}) {
        EXPECT_EQ(maximum[0], 2.0F);
        EXPECT_EQ(maximum[1], -2.0F);
        EXPECT_EQ(maximum[2], 3.0F);
        EXPECT_TRUE(std::isnan(maximum[3]));
    }
}

} // namespace
} // namespace springdrive::contact
