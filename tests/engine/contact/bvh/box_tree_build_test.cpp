// Covers engine/contact/bvh/box_tree_build.cpp.
#include "engine/contact/bvh/box_tree_build.h"

#include "tests/engine/contact/bvh/box_sets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace springdrive::contact {
namespace {

using testing::Boxes;
using testing::BoxSet;

SearchBudget no_limit() { return {1 << 30}; }

TEST(BoxTreeBuild, NumbersEveryBoxOnce) {
    std::mt19937_64 random(1);
    for (const BoxSet &set : testing::box_sets(random)) {
        std::vector<std::uint32_t> numbers = BoxTree(set.boxes, 1).order();
        std::ranges::sort(numbers);
        std::vector<std::uint32_t> expected(set.boxes.size());
        std::iota(expected.begin(), expected.end(), 0U);
        EXPECT_EQ(numbers, expected) << set.name;
    }
}

/// Exactly: the rounding to float may not cut off a corner, nor may that of the search.
TEST(BoxTreeBuild, FindsEachBoxAtEachOfItsCorners) {
    std::mt19937_64 random(2);
    for (const BoxSet &set : testing::box_sets(random)) {
        const BoxTree tree(set.boxes, 1);
        for (std::uint32_t item = 0; item < set.boxes.size(); ++item) {
            const Eigen::AlignedBox3d &box = set.boxes[tree.order()[item]];
            const auto corner_type = static_cast<Eigen::AlignedBox3d::CornerType>(random() % 8);
            const Vector3 corner = box.corner(corner_type);
            bool found_within = false;
            bool found_along = false;
            SearchBudget budget = no_limit();
            tree.within(corner, 0.0, budget, [&](std::uint32_t visited, double squared) {
                found_within |= visited == item;
                return squared;
            });
            tree.along(corner, corner, 0.0, budget, [&](std::uint32_t visited, double last) {
                found_along |= visited == item;
                return last;
            });
            ASSERT_TRUE(found_within && found_along) << set.name << ": " << corner.transpose();
        }
    }
}

TEST(BoxTreeBuild, GivesTheSameTreeForAnyNumberOfThreads) {
    const Boxes boxes = testing::boxes_of(testing::bumpy_sphere(5, 0.05));
    const auto walk = [&](const BoxTree &tree) {
        std::vector<std::uint32_t> visits;
        SearchBudget budget = no_limit();
        tree.within({0.03, 0.01, -0.02}, 0.06, budget, [&](std::uint32_t item, double) {
            visits.push_back(item);
            return 0.06 * 0.06;
        });
        visits.push_back(static_cast<std::uint32_t>(budget.effort_left));
        return visits;
    };
    const BoxTree of_one_thread(boxes, 1);
    const std::vector<std::uint32_t> expected = walk(of_one_thread);
    EXPECT_GT(expected.size(), 1000U);
    for (const unsigned threads : {2U, 5U}) {
        const BoxTree tree(boxes, threads);
        EXPECT_EQ(tree.order(), of_one_thread.order());
        EXPECT_EQ(walk(tree), expected);
    }
}

TEST(BoxTreeBuild, StaysSmallAndMovesItsOrderOut) {
    const Boxes boxes = testing::boxes_of(testing::icosphere(5, 0.05));
    BoxTree tree(boxes, 2);
    EXPECT_LT(tree.bytes(), 80 * boxes.size());
    const std::size_t with_order = tree.bytes();
    EXPECT_EQ(tree.take_order().size(), boxes.size());
    EXPECT_EQ(tree.bytes(), with_order - sizeof(std::uint32_t) * boxes.size());
}

/// A search for a point costs a few nodes for each level of the tree, even where no plane divides
/// the boxes well.
TEST(BoxTreeBuild, KeepsPointSearchesShort) {
    std::mt19937_64 random(3);
    const Boxes boxes = testing::random_boxes(random, 20000, 0.1, 1e-4);
    const BoxTree tree(boxes, 1);
    int nodes = 0;
    for (int i = 0; i < 1000; ++i) {
        SearchBudget budget{1000};
        EXPECT_TRUE(tree.within(boxes[random() % boxes.size()].center(), 0.0, budget,
                                [](std::uint32_t, double) { return 0.0; }));
        nodes += 1000 - budget.effort_left;
    }
    EXPECT_LT(nodes, 20 * 1000); // five levels hold 32,768
}

TEST(NumberedBox, EnclosesTheBoxTightly) {
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
