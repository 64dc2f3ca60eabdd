// Covers app/figures/name_places.cpp.
#include "app/figures/name_places.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

namespace springdrive::app {
namespace {

using Corners = std::vector<std::optional<NameCorner>>;

TEST(NamePlaces, StandToTheRightAndAboveWhereThereIsRoom) {
    EXPECT_EQ(name_corners({{{0.5, 0.5}, 8}}, {{0.5, 0.5}}, {}),
              (Corners{NameCorner::right_above}));
}

TEST(NamePlaces, StayWithinTheFrame) {
    // Ten letters are some 0.09 wide, a letter some 0.03 high.
    EXPECT_EQ(name_corners({{{0.95, 0.5}, 10}}, {}, {}), (Corners{NameCorner::left_above}));
    EXPECT_EQ(name_corners({{{0.5, 0.99}, 10}}, {}, {}), (Corners{NameCorner::right_below}));
    EXPECT_EQ(name_corners({{{0.95, 0.99}, 10}}, {}, {}), (Corners{NameCorner::left_below}));
    EXPECT_EQ(name_corners({{{0.5, 0.5}, 200}}, {}, {}), (Corners{std::nullopt}));
}

TEST(NamePlaces, CoverNeitherPointsNorOneAnother) {
    // A second point stands where the name would.
    EXPECT_EQ(name_corners({{{0.5, 0.5}, 8}}, {{0.5, 0.5}, {0.54, 0.53}}, {}),
              (Corners{NameCorner::right_below}));
    // Names of points at one place take the corners in turn, and the fifth has none.
    const PointName name{{0.5, 0.5}, 8};
    EXPECT_EQ(name_corners({name, name, name, name, name}, {name.point}, {}),
              (Corners{NameCorner::right_above, NameCorner::right_below, NameCorner::left_above,
                       NameCorner::left_below, std::nullopt}));
}

TEST(NamePlaces, CrossTheFewestStrokes) {
    const Stroke above{{0.5, 0.5}, {0.9, 0.55}};
    const Stroke below{{0.5, 0.5}, {0.9, 0.45}};
    const Stroke far{{0.0, 0.9}, {1.0, 0.9}};
    EXPECT_EQ(name_corners({{{0.5, 0.5}, 8}}, {{0.5, 0.5}}, {above, far}),
              (Corners{NameCorner::right_below}));
    EXPECT_EQ(name_corners({{{0.5, 0.5}, 8}}, {{0.5, 0.5}}, {above, below}),
              (Corners{NameCorner::left_above}));
    // Where all are crossed, one is taken all the same.
    const Stroke to_the_left{{0.1, 0.55}, {0.5, 0.5}};
    const Stroke left_below{{0.1, 0.45}, {0.5, 0.5}};
    EXPECT_EQ(
        name_corners({{{0.5, 0.5}, 8}}, {{0.5, 0.5}}, {above, below, to_the_left, left_below}),
        (Corners{NameCorner::right_above}));
}

} // namespace
} // namespace springdrive::app
