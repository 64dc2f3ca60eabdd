// Covers engine/contact/bvh/numbered_box.cpp.
#include "engine/contact/bvh/numbered_box.h"

#include "tests/engine/contact/mesh/soups.h"

#include <gtest/gtest.h>

#include <cmath>

namespace springdrive::contact {
namespace {

TEST(NumberedBox, HoldsTheBoxAndLittleMore) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> exponent(-30.0, 3.0);
    for (int i = 0; i < 20000; ++i) {
        const double half_m = std::pow(10.0, exponent(random));
        Eigen::AlignedBox3d box(testing::random_vector(random, half_m));
        box.extend(testing::random_vector(random, half_m));
        const bool is_exact = i % 2 == 0; // needs no rounding
        for (int axis = 0; is_exact && axis < 3; ++axis) {
            box.min()[axis] = double{static_cast<float>(box.min()[axis])};
            box.max()[axis] = double{static_cast<float>(box.max()[axis])};
        }
        const Bounds bounds = NumberedBox(box, 0).bounds();
        for (int axis = 0; axis < 3; ++axis) {
            const double lower = bounds.lower[axis];
            const double upper = bounds.upper[axis];
            ASSERT_LE(lower, box.min()[axis]);
            ASSERT_GE(upper, box.max()[axis]);
            // A step of up to two floats, and the roundings before and after it.
            const double more = is_exact ? 0.0 : 4.0 * 0x1p-24;
            ASSERT_GE(lower, box.min()[axis] - more * std::abs(box.min()[axis]) - 0x1p-125);
            ASSERT_LE(upper, box.max()[axis] + more * std::abs(box.max()[axis]) + 0x1p-125);
        }
    }
}

TEST(NumberedBox, KeepsItsNumber) {
    const Eigen::AlignedBox3d box(Vector3(-1, -2, -3), Vector3(1, 2, 3));
    for (const std::uint32_t number : {0U, 1U, 255U, 0x7FFFFFU, 0x800000U, 0x3FFFFFFFU}) {
        EXPECT_EQ(NumberedBox(box, number).number(), number);
    }
}

} // namespace
} // namespace springdrive::contact
