// Covers engine/contact/mesh/point_tree.cpp.
#include "engine/contact/mesh/point_tree.h"

#include "tests/engine/contact/mesh/soups.h"

#include <gtest/gtest.h>

#include <set>
#include <tuple>

namespace springdrive::contact {
namespace {

using testing::random_vector;

std::set<std::uint32_t> found_along(const PointTree &tree, const Vector3 &from_m,
                                    const Vector3 &to_m, double reach_m) {
    std::set<std::uint32_t> found;
    std::ignore =
        tree.visit_along(from_m, to_m, reach_m, [&](std::uint32_t point, double fraction, double) {
            EXPECT_TRUE(found.insert(point).second);
            EXPECT_GT(fraction, 0.0);
            EXPECT_LT(fraction, 1.0);
            return false;
        });
    return found;
}

/// Round-off may decide about points this near to the border [m].
constexpr double kRoundOff_m = 1e-14;

TEST(PointTree, FindsWhatASearchOfAllFinds) {
    std::mt19937_64 random(1);
    std::size_t found_in_all = 0;
    for (int round = 0; round < 200; ++round) {
        std::vector<Vector3> points_m;
        for (int i = 0; i < 200; ++i) {
            points_m.push_back(random_vector(random, 0.1));
            if (round % 2 == 0) { // all in a plane, many at the same height
                points_m.back()[2] = 0.0;
                points_m.back()[0] = std::round(100.0 * points_m.back()[0]) / 100.0;
            }
        }
        const PointTree tree(points_m);
        for (int i = 0; i < 20; ++i) {
            const Vector3 from_m = random_vector(random, 0.1);
            Vector3 to_m = random_vector(random, 0.1);
            to_m[i % 3] = i % 2 == 0 ? from_m[i % 3] : to_m[i % 3];
            const double reach_m = 0.02;
            const std::set<std::uint32_t> found = found_along(tree, from_m, to_m, reach_m);
            found_in_all += found.size();
            const Vector3 way = to_m - from_m;
            for (std::uint32_t point = 0; point < points_m.size(); ++point) {
                const double along_m = (points_m[point] - from_m).dot(way.normalized());
                const double beside_m = (points_m[point] - from_m).cross(way.normalized()).norm();
                const double inside_m =
                    std::min({along_m, way.norm() - along_m, reach_m - beside_m});
                if (std::abs(inside_m) > kRoundOff_m) {
                    ASSERT_EQ(found.contains(point), inside_m > 0.0);
                }
            }
        }
    }
    EXPECT_GT(found_in_all, 10000U);
}

TEST(PointTree, StopsWhenToldTo) {
    const PointTree tree(std::vector<Vector3>(1000, Vector3(0.5, 0.0, 0.0)));
    int visits = 0;
    std::ignore = tree.visit_along(Vector3::Zero(), Vector3::UnitX(), 0.1,
                                   [&](std::uint32_t, double, double) { return ++visits == 3; });
    EXPECT_EQ(visits, 3);
}

TEST(PointTree, IsTheSameForAnyNumberOfThreads) {
    std::mt19937_64 random(1);
    std::vector<Vector3> points_m;
    while (points_m.size() < 50'000) {
        points_m.push_back(random_vector(random, 0.1));
    }
    const auto order = [&](unsigned threads) {
        std::vector<std::uint32_t> found;
        std::ignore = PointTree(points_m, threads)
                          .visit_along(Vector3::Zero(), Vector3::Constant(0.1), 0.02,
                                       [&](std::uint32_t point, double, double) {
                                           found.push_back(point);
                                           return false;
                                       });
        return found;
    };
    EXPECT_GT(order(1).size(), 100U);
    EXPECT_EQ(order(2), order(1));
    EXPECT_EQ(order(3), order(1));
}

TEST(PointTree, FindsNothingWhenEmpty) {
    EXPECT_TRUE(found_along(PointTree({}), Vector3::Zero(), Vector3::UnitX(), 1.0).empty());
}

} // namespace
} // namespace springdrive::contact
