// Covers engine/contact/bvh: box_tree.h and box_tree_build.cpp.
#include "engine/contact/bvh/box_tree.h"
#include "engine/contact/bvh/box_tree_build.h"
#include "tests/engine/contact/mesh/soups.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <vector>

namespace springdrive::contact {
namespace {

using testing::random_vector;

using Boxes = std::vector<Eigen::AlignedBox3d>;

struct BoxSet {
    std::string name;
    Boxes boxes;
    Vector3 centre_m = Vector3::Zero();
    double half_m = 0.1; ///< most boxes lie within so much of the centre
};

Eigen::AlignedBox3d box_about(const Vector3 &centre_m, const Vector3 &half_m) {
    return {Vector3(centre_m - half_m), Vector3(centre_m + half_m)};
}

Boxes random_boxes(std::mt19937_64 &random, int count, double half_m, double size_m,
                   const Vector3 &centre_m = Vector3::Zero()) {
    Boxes boxes;
    for (int i = 0; i < count; ++i) {
        const Vector3 at = centre_m + random_vector(random, half_m);
        boxes.push_back(box_about(at, random_vector(random, size_m).cwiseAbs()));
    }
    return boxes;
}

Boxes triangle_boxes(const contact::TriangleSoup &soup) {
    Boxes boxes(soup.triangles.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        for (const Vector3 &corner : testing::corners(soup, i)) {
            boxes[i].extend(corner);
        }
    }
    return boxes;
}

/// Nested about one corner, each half as large again as the last, which makes a tree deep.
Boxes growing_boxes(int count) {
    Boxes boxes;
    for (int i = 0; i < count; ++i) {
        boxes.emplace_back(Vector3::Zero(), Vector3::Constant(1e-12 * std::pow(1.5, i)));
    }
    return boxes;
}

std::vector<BoxSet> box_sets(std::mt19937_64 &random) {
    const Vector3 far(1000.0, -999.9, 998.7);
    std::vector<BoxSet> sets{
        {"one", random_boxes(random, 1, 0.01, 0.05)},
        {"two", random_boxes(random, 2, 0.05, 0.05)},
        {"nine", random_boxes(random, 9, 0.1, 0.05)},
        {"scattered", random_boxes(random, 700, 0.1, 0.005)},
        {"overlapping", random_boxes(random, 300, 0.1, 0.08)},
        {"sphere", triangle_boxes(testing::bumpy_sphere(3, 0.08))},
        {"points", random_boxes(random, 500, 0.1, 0.0)},
        {"identical", Boxes(1000, box_about({0.01, 0.02, 0.03}, {0.02, 0.03, 0.01}))},
        {"identical points", Boxes(1000, box_about({0.01, 0.02, 0.03}, Vector3::Zero()))},
        {"growing", growing_boxes(64)},
        {"far", random_boxes(random, 500, 0.1, 0.005, far), far},
        {"large", random_boxes(random, 500, 1000.0, 40.0), Vector3::Zero(), 1000.0},
        {"line", random_boxes(random, 500, 0.1, 0.001)},
        {"plane", random_boxes(random, 500, 0.1, 0.01)},
    };
    for (Eigen::AlignedBox3d &box : (sets.end() - 2)->boxes) {
        box.min().tail<2>().setConstant(0.02);
        box.max().tail<2>().setConstant(0.02);
    }
    for (Eigen::AlignedBox3d &box : sets.back().boxes) {
        box.min().y() = box.max().y() = -0.01;
    }
    return sets;
}

/// The fraction at which a motion enters a box grown by `reach_m`, or infinity if it never does.
double entry_fraction(const Eigen::AlignedBox3d &box, const Vector3 &from_m, const Vector3 &to_m,
                      double reach_m) {
    double enters = 0.0;
    double leaves = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double lower = box.min()[axis] - reach_m - from_m[axis];
        const double upper = box.max()[axis] + reach_m - from_m[axis];
        const double length = to_m[axis] - from_m[axis];
        if (length == 0.0) {
            leaves = lower <= 0.0 && upper >= 0.0 ? leaves : -1.0;
        } else {
            enters = std::max(enters, std::min(lower / length, upper / length));
            leaves = std::min(leaves, std::max(lower / length, upper / length));
        }
    }
    return enters <= leaves ? enters : INFINITY;
}

struct Motion {
    Vector3 from_m;
    Vector3 to_m;
    double reach_m = 0.0;
};

/// Of all lengths, zero among them; some along an axis or in a plane of two, some that start in
/// the middle of a box or on its corner.
Motion random_motion(std::mt19937_64 &random, const BoxSet &set) {
    std::uniform_real_distribution<double> exponent(-7.0, 0.0);
    Motion motion;
    motion.from_m = set.centre_m + random_vector(random, 1.2 * set.half_m);
    const Eigen::AlignedBox3d &box = set.boxes[random() % set.boxes.size()];
    switch (random() % 4) {
    case 0:
        motion.from_m = box.center();
        break;
    case 1:
        motion.from_m = random() % 2 == 0 ? box.min() : box.max();
        break;
    default:
        break;
    }
    Vector3 step = std::pow(10.0, exponent(random)) * random_vector(random, 3.0 * set.half_m);
    for (int axis = 0; axis < 3; ++axis) {
        step[axis] = random() % 4 == 0 ? 0.0 : step[axis];
    }
    motion.to_m = motion.from_m + step;
    motion.reach_m = random() % 3 == 0 ? 0.0 : set.half_m * std::pow(10.0, exponent(random));
    return motion;
}

SearchBudget unlimited() { return {1 << 30}; }

/// The error of the reference search in double [m]: some round-offs of a coordinate.
double round_off_m(const BoxSet &set) { return 1e-15 * (set.centre_m.norm() + 2.0 * set.half_m); }

/// How much farther than requested the tree may search [m]: two roundings of a coordinate to float
/// on either side, and kSlack of the motion, doubled.
double allowance_m(const BoxSet &set, double length_m) {
    const double coordinate_m = set.centre_m.cwiseAbs().maxCoeff() + 6.0 * set.half_m;
    return 8.0 * 0x1p-24 * coordinate_m + 4.0 * double{kSlack} * length_m;
}

/// Which items a search visits, each once.
class Visited {
public:
    explicit Visited(const BoxTree &tree) : is_visited_(tree.order().size()) {}
    void add(std::uint32_t item) {
        ASSERT_LT(item, is_visited_.size());
        EXPECT_FALSE(is_visited_[item]);
        is_visited_[item] = true;
    }
    bool operator[](std::uint32_t item) const { return is_visited_[item]; }

private:
    std::vector<bool> is_visited_;
};

TEST(BoxTree, AlongFindsTheFirstEntryWhileTheMotionShrinks) {
    std::mt19937_64 random(2);
    for (const BoxSet &set : box_sets(random)) {
        const BoxTree tree(set.boxes, 1);
        for (int i = 0; i < 300; ++i) {
            const Motion motion = random_motion(random, set);
            const Vector3 &from = motion.from_m;
            const Vector3 &to = motion.to_m;
            const double reach = motion.reach_m;
            double expected = 1.0;
            for (const Eigen::AlignedBox3d &box : set.boxes) {
                expected = std::min(expected, entry_fraction(box, from, to, reach));
            }
            double last_left = 1.0;
            SearchBudget budget = unlimited();
            const double found =
                tree.along(from, to, reach, budget, [&](std::uint32_t item, double last) {
                    EXPECT_EQ(last, last_left);
                    last_left = std::min(
                        last, entry_fraction(set.boxes[tree.order()[item]], from, to, reach));
                    return last_left;
                });
            ASSERT_EQ(found, expected) << set.name << " " << i;
        }
    }
}

/// On a wall counts as inside, also at zero, where floats are so dense that round-off does not
/// help.
TEST(BoxTree, AlongFindsBoxesThatTheMotionSlidesAlong) {
    std::mt19937_64 random(9);
    const Boxes boxes{Eigen::AlignedBox3d(Vector3(-1, -2, -4), Vector3(0, 0, 0)),
                      Eigen::AlignedBox3d(Vector3(0, 0, 0), Vector3(2, 3, 1))};
    const BoxTree tree(boxes, 1);
    for (int i = 0; i < 2000; ++i) {
        const Eigen::AlignedBox3d &box = boxes[random() % 2];
        Vector3 from = random_vector(random, 5.0);
        Vector3 to = random_vector(random, 5.0);
        const int axis = static_cast<int>(random() % 3);
        from[axis] = to[axis] = random() % 2 == 0 ? box.min()[axis] : box.max()[axis];
        Visited visited(tree);
        SearchBudget budget = unlimited();
        tree.along(from, to, 0.0, budget, [&](std::uint32_t item, double last) {
            visited.add(item);
            return last;
        });
        for (std::uint32_t item = 0; item < 2; ++item) {
            ASSERT_TRUE(visited[item] ||
                        entry_fraction(boxes[tree.order()[item]], from, to, 0.0) > 1.0)
                << i;
        }
    }
}

/// Shrinking must save visits to be of use.
TEST(BoxTree, AlongSkipsWhatLiesBehindTheFractionLeft) {
    Boxes boxes;
    for (int i = 0; i < 1000; ++i) {
        boxes.push_back(box_about({1e-3 * i, 0, 0}, Vector3::Constant(1e-4)));
    }
    const BoxTree tree(boxes, 1);
    int visits = 0;
    SearchBudget budget = unlimited();
    tree.along({-1, 0, 0}, {1, 0, 0}, 0.0, budget, [&](std::uint32_t item, double last) {
        ++visits;
        return std::min(last, 0.5 + 0.5e-3 * tree.order()[item] + 1e-6);
    });
    EXPECT_LE(visits, 2);
    EXPECT_LT(unlimited().effort_left - budget.effort_left, 20 * kNodeEffort);
}

TEST(BoxTree, AlongVisitsWhatTheMotionEntersWithinItsBudgetAndNothingElse) {
    std::mt19937_64 random(3);
    for (const BoxSet &set : box_sets(random)) {
        const BoxTree tree(set.boxes, 1);
        int entered = 0;
        int cut_short = 0;
        for (int i = 0; i < 600; ++i) {
            SCOPED_TRACE(set.name + " " + std::to_string(i));
            const auto &[from, to, reach] = random_motion(random, set);
            Visited visited(tree);
            const bool is_limited = i % 2 == 0;
            const int nodes = i / 2 % 30;
            SearchBudget budget = is_limited ? SearchBudget{nodes * kNodeEffort} : unlimited();
            const double stop_at = is_limited && i % 3 == 0 ? 0.3 : 1.0;
            const double searched =
                tree.along(from, to, reach, budget, [&](std::uint32_t item, double last) {
                    visited.add(item);
                    return std::min(last, stop_at);
                });
            ASSERT_GE(budget.effort_left, 0);
            ASSERT_GE(searched, is_limited ? 0.0 : 1.0);
            cut_short += searched < stop_at ? 1 : 0;
            const double more = reach + allowance_m(set, (to - from).norm());
            for (std::uint32_t item = 0; item < set.boxes.size(); ++item) {
                const Eigen::AlignedBox3d &box = set.boxes[tree.order()[item]];
                if (visited[item]) {
                    ASSERT_LE(entry_fraction(box, from, to, more), 1.0);
                    ++entered;
                } else if (searched == 1.0) {
                    ASSERT_GT(entry_fraction(box, from, to, reach - round_off_m(set)), 1.0);
                } else {
                    ASSERT_GE(entry_fraction(box, from, to, reach - round_off_m(set)), searched);
                }
            }
        }
        EXPECT_GT(entered, 20) << set.name;
        EXPECT_GE(cut_short, 10) << set.name; // all those without any budget
    }
}

TEST(BoxTree, AlongSearchesFartherWithALargerBudget) {
    std::mt19937_64 random(4);
    const Boxes boxes = random_boxes(random, 5000, 0.1, 0.003);
    const BoxTree tree(boxes, 1);
    const Vector3 from = Vector3::Constant(-0.11);
    const auto searched_with = [&](int nodes) {
        SearchBudget budget{nodes * kNodeEffort};
        return tree.along(from, -from, 1e-3, budget,
                          [](std::uint32_t, double last) { return last; });
    };
    EXPECT_EQ(searched_with(0), 0.0);
    EXPECT_GT(searched_with(40), 0.05);
    EXPECT_LT(searched_with(40), 1.0);
    EXPECT_EQ(searched_with(5000), 1.0);
}

TEST(BoxTree, WithinVisitsWhatIsNearAndNothingElse) {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> exponent(-6.0, 0.0);
    for (const BoxSet &set : box_sets(random)) {
        const BoxTree tree(set.boxes, 1);
        for (int i = 0; i < 300; ++i) {
            const Vector3 centre = random_motion(random, set).from_m;
            const double radius = set.half_m * std::pow(10.0, exponent(random));
            const double less = radius - round_off_m(set);
            const double more = radius * (1.0 + double{kSlack}) + allowance_m(set, 0.0);
            Visited visited(tree);
            SearchBudget budget = unlimited();
            const bool is_complete = tree.within(
                centre, radius, budget, [&](std::uint32_t item, double squared_distance) {
                    visited.add(item);
                    const Eigen::AlignedBox3d &box = set.boxes[tree.order()[item]];
                    const double distance = box.exteriorDistance(centre);
                    EXPECT_LE(std::sqrt(squared_distance), distance + round_off_m(set));
                    EXPECT_GE(std::sqrt(squared_distance),
                              distance * (1.0 - 2.0 * double{kSlack}) - allowance_m(set, 0.0));
                    return radius * radius;
                });
            EXPECT_TRUE(is_complete);
            for (std::uint32_t item = 0; item < set.boxes.size(); ++item) {
                const double distance = set.boxes[tree.order()[item]].exteriorDistance(centre);
                if (visited[item]) {
                    ASSERT_LE(distance, more) << set.name << " " << i;
                } else {
                    ASSERT_GT(distance, less) << set.name << " " << i;
                }
            }
        }
    }
}

TEST(BoxTree, WithinFindsTheNearestWhileTheBallShrinks) {
    std::mt19937_64 random(6);
    for (const BoxSet &set : box_sets(random)) {
        const BoxTree tree(set.boxes, 1);
        for (int i = 0; i < 300; ++i) {
            const Vector3 centre = set.centre_m + random_vector(random, 1.5 * set.half_m);
            const double radius = 4.0 * set.half_m;
            double expected = radius * radius;
            for (const Eigen::AlignedBox3d &box : set.boxes) {
                expected = std::min(expected, box.squaredExteriorDistance(centre));
            }
            double nearest = radius * radius;
            SearchBudget budget = unlimited();
            EXPECT_TRUE(tree.within(centre, radius, budget, [&](std::uint32_t item, double) {
                const Eigen::AlignedBox3d &box = set.boxes[tree.order()[item]];
                nearest = std::min(nearest, box.squaredExteriorDistance(centre));
                return nearest;
            }));
            ASSERT_EQ(nearest, expected) << set.name << " " << i;
        }
    }
}

TEST(BoxTree, WithinKeepsItsBudgetAndReportsWhetherItSufficed) {
    std::mt19937_64 random(7);
    const Boxes boxes = random_boxes(random, 3000, 0.1, 0.003);
    const BoxTree tree(boxes, 1);
    const auto nothing = [](std::uint32_t, double) { return 0.03 * 0.03; };
    SearchBudget whole = unlimited();
    EXPECT_TRUE(tree.within(Vector3::Zero(), 0.03, whole, nothing));
    const int needed = unlimited().effort_left - whole.effort_left;
    EXPECT_GT(needed, 5);
    SearchBudget just_enough{needed};
    EXPECT_TRUE(tree.within(Vector3::Zero(), 0.03, just_enough, nothing));
    EXPECT_EQ(just_enough.effort_left, 0);
    for (int effort = 0; effort < needed; effort += kNodeEffort) {
        SearchBudget too_little{effort};
        EXPECT_FALSE(tree.within(Vector3::Zero(), 0.03, too_little, nothing));
        EXPECT_EQ(too_little.effort_left, 0);
    }
}

TEST(BoxTree, VisitsNothingWhenEmpty) {
    const auto fail = [](std::uint32_t, double left) {
        ADD_FAILURE();
        return left;
    };
    for (const BoxTree &tree : {BoxTree(), BoxTree({}, 2)}) {
        SearchBudget budget{0};
        EXPECT_EQ(tree.along(-Vector3::Ones(), Vector3::Ones(), 1.0, budget, fail), 1.0);
        EXPECT_TRUE(tree.within(Vector3::Zero(), 1.0, budget, fail));
        EXPECT_TRUE(tree.order().empty());
    }
}

TEST(BoxTree, TerminatesForAnyQuery) {
    std::mt19937_64 random(8);
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const Boxes boxes = random_boxes(random, 1001, 0.1, 0.003);
    const BoxTree tree(boxes, 1);
    const std::vector<double> extreme_values{NAN,    kInfinity, -kInfinity, 1e300,
                                             -1e300, 1e39,      1e-320};
    for (const double value : extreme_values) {
        for (const double other : extreme_values) {
            int visits = 0;
            const auto count = [&](std::uint32_t item, double left) {
                EXPECT_LT(item, boxes.size());
                ++visits;
                return left;
            };
            const Vector3 from(0.01, value, other);
            const Vector3 to(other, 0.02, value);
            SearchBudget budget = unlimited();
            tree.along(from, to, 0.0, budget, count);
            tree.along(from, Vector3::Zero(), other, budget, count);
            tree.along(Vector3::Zero(), Vector3::Ones(), value, budget, count);
            tree.within(from, other, budget, count);
            tree.within(Vector3::Zero(), value, budget, count);
            tree.within(to, 0.01, budget, [](std::uint32_t, double) { return NAN; });
            EXPECT_LE(unlimited().effort_left - budget.effort_left, 6 * 1001 * kNodeEffort);
        }
    }
}

TEST(BoxTreeBuild, NumbersEveryBoxOnce) {
    std::mt19937_64 random(1);
    for (const BoxSet &set : box_sets(random)) {
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
    for (const BoxSet &set : box_sets(random)) {
        const BoxTree tree(set.boxes, 1);
        for (std::uint32_t item = 0; item < set.boxes.size(); ++item) {
            const Eigen::AlignedBox3d &box = set.boxes[tree.order()[item]];
            const auto corner_type = static_cast<Eigen::AlignedBox3d::CornerType>(random() % 8);
            const Vector3 corner = box.corner(corner_type);
            bool found_within = false;
            bool found_along = false;
            SearchBudget budget = unlimited();
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
    const Boxes boxes = triangle_boxes(testing::bumpy_sphere(5, 0.05));
    const auto walk = [&](const BoxTree &tree) {
        std::vector<std::uint32_t> visits;
        SearchBudget budget = unlimited();
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

/// A search for a point costs a few nodes for each level of the tree, even where no plane divides
/// the boxes well.
TEST(BoxTreeBuild, KeepsPointSearchesShort) {
    std::mt19937_64 random(3);
    const Boxes boxes = random_boxes(random, 20000, 0.1, 1e-4);
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
