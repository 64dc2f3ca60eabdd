// Covers engine/contact/bvh/box_tree_build.cpp, box_split.cpp and numbered_box.cpp.
#include "engine/contact/bvh/box_tree.h"

#include "tests/engine/contact/bvh/box_sets.h"

#include <gtest/gtest.h>

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
        visits.push_back(static_cast<std::uint32_t>(budget.nodes_left));
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

TEST(BoxTreeBuild, StaysSmallAndHandsItsOrderOver) {
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
        nodes += 1000 - budget.nodes_left;
    }
    EXPECT_LT(nodes, 20 * 1000); // five levels hold 32,768
}

} // namespace
} // namespace springdrive::contact
