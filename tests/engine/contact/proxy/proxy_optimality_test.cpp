// Covers engine/contact/proxy/proxy_solver.cpp and proxy.cpp: wherever the proxy rests, no point
// nearer to the tip can be reached, and its path crosses no surface; also where proxies fail: thin
// walls, fast tips, edges and corners of every kind, meshes with faults, and places where hundreds
// of triangles meet.
#include "engine/contact/proxy/proxy.h"

#include "engine/contact/mesh/fan_grading.h"
#include "engine/lab/rig/brute_force_proxy.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/engine/contact/proxy/optimality.h"
#include "tests/support/hard_meshes.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

namespace springdrive::contact {
namespace {

using testing::random_direction;
using testing::random_vector;

/// Conditions hold to this [m].
constexpr double kHolds_m = 1e-9;

struct Walk {
    TriangleSoup soup;
    double reach_m = kClearance_m;
    double extent_m = 0.05; ///< of the tip's wandering
    double step_m = 3e-3;
    int steps = 60;
    bool is_closed = false; ///< then the tip comes from outside, and the proxy stays there
};

/// Counts of contacts, so that no test passes vacuously.
struct Met {
    int touching = 0;
    int edges = 0;
    int vertices = 0;
    int unsettled = 0;
};

/// Moves a tip at random and compares every step with brute force.
void walk(const Walk &how, std::mt19937_64 &random, Met &met) {
    const HapticSurface surface(how.soup);
    Proxy proxy(how.reach_m);
    Vector3 tip = how.is_closed ? Vector3(1.2 * how.extent_m * random_direction(random))
                                : random_vector(random, how.extent_m);
    proxy.reset(tip);
    // A start nearer than the reach keeps its distance; only from outside is the full reach kept.
    if (testing::distance_to_soup(how.soup, tip) < how.reach_m) {
        return;
    }
    Vector3 heading = how.is_closed ? Vector3(-tip.normalized()) : random_direction(random);
    for (int i = 0; i < how.steps; ++i) {
        heading = (heading + 0.5 * random_direction(random)).normalized();
        tip += how.step_m * heading;
        if (tip.norm() > how.extent_m) {
            heading = -tip.normalized();
        }
        const Contact contact = proxy.update(surface, tip);
        // Round a curved offset the last micrometre may take more than one tick, and so may steps
        // deep within a shape.
        ASSERT_TRUE(contact.settled || how.reach_m > kClearance_m || how.is_closed);
        if (how.is_closed) {
            ASSERT_NEAR(testing::winding_number(how.soup, contact.x0_m), 0.0, 1e-3) << i;
        }
        met.unsettled += contact.settled ? 0 : 1;
        ASSERT_EQ(contact.touching, contact.x0_m != tip);
        const double distance_m = testing::distance_to_soup(how.soup, contact.x0_m);
        ASSERT_GT(distance_m, how.reach_m - 2e-12); // twice the slack
        const ProxyPath &path = proxy.path();
        ASSERT_EQ(path[path.size() - 1], contact.x0_m);
        for (std::size_t piece = 0; piece + 1 < path.size(); ++piece) {
            for (std::size_t t = 0; t < how.soup.triangles.size(); ++t) {
                ASSERT_FALSE(
                    testing::crosses(testing::corners(how.soup, t), path[piece], path[piece + 1]));
            }
        }
        if (!contact.touching) {
            continue;
        }
        ++met.touching;
        met.edges += contact.active_constraints == 2 ? 1 : 0;
        met.vertices += contact.active_constraints == 3 ? 1 : 0;
        const std::vector<Vector3> normals =
            testing::pushes(how.soup, contact.x0_m, how.reach_m, 1e-10);
        if (contact.settled) {
            ASSERT_LT(testing::unexplained_m(contact.x0_m - tip, normals), kHolds_m)
                << "step " << i;
        } else {
            ASSERT_LT((contact.x0_m - tip).norm(), (proxy.path()[0] - tip).norm()) << "step " << i;
        }
    }
}

TEST(ProxyOptimality, HoldsAmongRandomTriangles) {
    std::mt19937_64 random(1);
    Met met;
    for (int mesh = 0; mesh < 1500; ++mesh) {
        Walk how;
        how.soup = testing::random_soup(random, 20 + mesh % 30, 0.04, 0.03);
        ASSERT_NO_FATAL_FAILURE(walk(how, random, met)) << "mesh " << mesh;
    }
    EXPECT_GT(met.touching, 10000); // not vacuous
    EXPECT_GT(met.edges, 1000);
    EXPECT_GT(met.vertices, 100);
}

TEST(ProxyOptimality, HoldsForAProxyWithARadius) {
    std::mt19937_64 random(2);
    Met met;
    for (int mesh = 0; mesh < 500; ++mesh) {
        Walk how;
        how.reach_m = mesh % 2 == 0 ? 0.5e-3 : 3e-3;
        how.soup = testing::random_soup(random, 5 + mesh % 10, 0.04, 0.03);
        ASSERT_NO_FATAL_FAILURE(walk(how, random, met)) << "mesh " << mesh;
    }
    EXPECT_GT(met.touching, 1500);
    EXPECT_GT(met.edges, 20);
    EXPECT_LT(met.unsettled, met.touching / 200);
}

/// A closed shape with random hills and valleys, at random in space.
TriangleSoup random_hills(std::mt19937_64 &random) {
    TriangleSoup soup = testing::icosphere(1 + static_cast<int>(random() % 2), 1.0);
    const Vector3 waves = random_vector(random, 4.0);
    const Vector3 phase = random_vector(random, 3.0);
    for (Vector3 &vertex : soup.vertices_m) {
        const Vector3 u = vertex;
        vertex *= 0.03 * (1.0 + 0.25 * std::sin(waves.dot(u) + phase[0]) +
                          0.2 * std::cos(3.0 * waves[0] * u.y() + phase[1]));
    }
    Eigen::Isometry3d motion(Eigen::AngleAxisd(3.0 * phase[2], random_direction(random)));
    return testing::moved(soup, motion);
}

TEST(ProxyOptimality, HoldsOnClosedShapes) {
    std::mt19937_64 random(3);
    Met met;
    for (int mesh = 0; mesh < 300; ++mesh) {
        Walk how;
        how.soup = random_hills(random);
        how.step_m = 2e-3;
        how.is_closed = true;
        ASSERT_NO_FATAL_FAILURE(walk(how, random, met)) << "mesh " << mesh;
    }
    EXPECT_GT(met.touching, 3000);
    EXPECT_GT(met.edges, 300);
    EXPECT_LT(met.unsettled, met.touching / 200);
}

/// A tip at 1 kHz that moves randomly within a box at a given speed.
class RandomBoxWalk {
public:
    RandomBoxWalk(std::uint64_t seed, const Vector3 &start_m, const Vector3 &half_m,
                  double speed_m_per_s)
        : random_(seed), tip_m_(start_m), half_m_(half_m), step_m_(1e-3 * speed_m_per_s) {}

    Vector3 next() {
        heading_ = (heading_ + 0.3 * random_direction(random_)).normalized();
        tip_m_ += step_m_ * heading_;
        for (int axis = 0; axis < 3; ++axis) {
            if (std::abs(tip_m_[axis]) > half_m_[axis]) {
                tip_m_[axis] = std::clamp(tip_m_[axis], -half_m_[axis], half_m_[axis]);
                heading_[axis] = -heading_[axis];
            }
        }
        return tip_m_;
    }

private:
    std::mt19937_64 random_;
    Vector3 tip_m_;
    Vector3 half_m_;
    double step_m_;
    Vector3 heading_{Vector3::UnitX()};
};

class ProxyAtSpeed : public ::testing::TestWithParam<double> {};

TEST_P(ProxyAtSpeed, NeverPassesAPlateOfATenthOfAMillimetre) {
    const HapticSurface plate(box_soup({-0.1, -0.05e-3, -0.1}, {0.1, 0.05e-3, 0.1}));
    RandomBoxWalk walk(1, {0.0, 0.02, 0.0}, {0.08, 0.03, 0.08}, GetParam());
    Proxy proxy;
    proxy.reset({0.0, 0.02, 0.0});
    const double top_m = 0.05e-3 + kClearance_m;
    for (int i = 0; i < 20000; ++i) {
        const Vector3 tip = walk.next();
        const Contact contact = proxy.update(plate, tip);
        // The tip never gets around the plate, so this is where the proxy is.
        const Vector3 expected(tip.x(), std::max(tip.y(), top_m), tip.z());
        ASSERT_LT((contact.x0_m - expected).norm(), 1e-12) << i;
    }
}

TEST_P(ProxyAtSpeed, FollowsTheWallsEdgesAndCornersOfARoom) {
    const Vector3 half(0.02, 0.03, 0.04);
    const HapticSurface room(testing::turned_inside_out(box_soup(-half, half)));
    RandomBoxWalk walk(2, Vector3::Zero(), 1.3 * half, GetParam());
    Proxy proxy;
    proxy.reset(Vector3::Zero());
    std::array<int, 4> seen{};
    const Vector3 inner = half - Vector3::Constant(kClearance_m);
    for (int i = 0; i < 20000; ++i) {
        const Vector3 tip = walk.next();
        const Contact contact = proxy.update(room, tip);
        ASSERT_LT((contact.x0_m - tip.cwiseMin(inner).cwiseMax(-inner)).norm(), 1e-12) << i;
        ++seen[static_cast<std::size_t>(contact.active_constraints)];
    }
    EXPECT_GT(*std::ranges::min_element(seen), 10); // walls, edges and corners
}

TEST_P(ProxyAtSpeed, NeverEntersASolidWhateverItsEdges) {
    // A knife of two degrees, a needle of fifteen, and a bowl with a wall of a millimetre.
    for (const TriangleSoup &soup : {testing::knife(), testing::needle(), testing::bowl(12)}) {
        const HapticSurface solid(soup);
        ASSERT_EQ(solid.report().closed_components, 1U);
        ASSERT_EQ(solid.report().inward_components, 0U);
        RandomBoxWalk walk(3, Vector3::Constant(0.02), Vector3::Constant(0.021), GetParam());
        Proxy proxy;
        proxy.reset(Vector3::Constant(0.02));
        int touching = 0;
        const int steps = GetParam() < 0.5 ? 12000 : 4000;
        for (int i = 0; i < steps; ++i) {
            const Vector3 tip = walk.next();
            const Contact contact = proxy.update(solid, tip);
            ASSERT_TRUE(contact.settled) << i;
            touching += contact.touching ? 1 : 0;
            if (contact.touching) {
                ASSERT_GT(testing::distance_to_soup(soup, contact.x0_m), kClearance_m - 2e-12) << i;
                ASSERT_NEAR(testing::winding_number(soup, contact.x0_m), 0.0, 1e-3) << i;
                ASSERT_LT(testing::unexplained_m(
                              contact.x0_m - tip,
                              testing::pushes(soup, contact.x0_m, kClearance_m, 1e-10)),
                          1e-9)
                    << i;
            }
        }
        EXPECT_GT(touching, 10);
    }
}

INSTANTIATE_TEST_SUITE_P(MetresPerSecond, ProxyAtSpeed, ::testing::Values(0.1, 1.0, 10.0));

/// A path over a sphere of 30 mm, 1 mm under its surface, at 0.1 m/s.
Vector3 tip_under_sphere(int tick) {
    const double t = 1e-4 / 0.029 * tick;
    return 0.029 * Vector3(std::sin(t), std::cos(t), std::sin(0.3 * t)).normalized();
}

/// Sphere by sphere: with faults, and by how much the proxy on it may differ from that on a clean
/// one.
TEST(ProxyOnFaults, IsNotHeldOrLetThrough) {
    std::mt19937_64 random(5);
    const auto cracked = [&](const TriangleSoup &sphere) { // corners off by up to 1 µm
        TriangleSoup soup;
        for (std::size_t i = 0; i < sphere.triangles.size(); ++i) {
            testing::Corners corners = testing::corners(sphere, i);
            for (Vector3 &corner : corners) {
                corner += random_vector(random, 1e-6 / std::sqrt(3.0));
            }
            testing::add_triangle(soup, corners);
        }
        return soup;
    };
    const TriangleSoup coarse = testing::icosphere(2, 0.03);
    const TriangleSoup fine = testing::icosphere(4, 0.03);
    TriangleSoup flipped = fine;
    for (auto &triangle : flipped.triangles) {
        if (random() % 20 == 0) {
            std::swap(triangle[1], triangle[2]);
        }
    }
    TriangleSoup repeated; // and with slivers
    for (std::size_t i = 0; i < fine.triangles.size(); ++i) {
        const auto [a, b, c] = testing::corners(fine, i);
        testing::add_triangle(repeated, {a, b, c});
        testing::add_triangle(repeated, {b, c, a});
        testing::add_triangle(repeated, {a, b, 0.5 * (a + b)});
        testing::add_triangle(repeated, {a, a, c});
    }
    struct Case {
        const TriangleSoup &clean;
        TriangleSoup faulty;
        double allowed_m;
    };
    // Corners move by up to 2 µm when they become one, which turns facets by that over their size:
    // the foot of a tip a millimetre below moves by a few µm, to the next facet at most.
    for (const Case &one : std::vector<Case>{{coarse, cracked(coarse), 1.5e-3 * 1.1 / 4.0},
                                             {fine, cracked(fine), 1.5e-3 * 1.1 / 16.0},
                                             {fine, flipped, 1e-12},
                                             {fine, repeated, 1e-12}}) {
        const HapticSurface clean_surface(one.clean);
        const HapticSurface faulty_surface(one.faulty);
        Proxy clean;
        Proxy faulty;
        clean.reset({0.0, 0.05, 0.0});
        faulty.reset({0.0, 0.05, 0.0});
        for (int i = 0; i < 8000; ++i) {
            const Vector3 tip = tip_under_sphere(i);
            ASSERT_LT(
                (clean.update(clean_surface, tip).x0_m - faulty.update(faulty_surface, tip).x0_m)
                    .norm(),
                one.allowed_m)
                << i;
        }
    }
}

TEST(ProxyOnFaults, ClimbsStepsTooLowToFeelAndNoOthers) {
    // Two sheets side by side, one a little higher.
    for (const double step_m : {1e-9, 5e-8, 1e-6, 9.9e-6, 1.03e-5, 5e-5}) {
        TriangleSoup soup = box_soup({-0.05, -0.01, -0.05}, {0.0, 0.0, 0.05});
        soup = testing::joined(soup, box_soup({0.0, -0.01, -0.05}, {0.05, step_m, 0.05}));
        const HapticSurface surface(soup);
        Proxy proxy;
        proxy.reset({-0.002, 0.01, 0.0});
        Contact contact;
        for (int i = 0; i <= 23; ++i) {
            contact = proxy.update(surface, {-0.00211 + 1e-4 * i, -1.5e-3, 0.0});
        }
        // 0.19 mm past the step, 12 µm nearer on it: higher steps hold it as walls do.
        EXPECT_EQ(contact.x0_m.x() > 0.05e-3, step_m < 1e-5) << step_m;
    }
}

constexpr double kTurn = 2.0 * std::numbers::pi;

/// A cone, or a saddle where it has a wave; rough where it has noise.
TriangleSoup fan_of(std::uint32_t count, double slope, double wave, double noise,
                    std::mt19937_64 &random) {
    constexpr double kRadius_m = 5e-3;
    std::uniform_real_distribution<double> one(-1.0, 1.0);
    std::vector<Vector3> rim_m;
    for (std::uint32_t i = 0; i < count; ++i) {
        const double phi = kTurn * i / count;
        const double height = slope + wave * std::cos(2.0 * phi) + noise * one(random);
        rim_m.emplace_back(kRadius_m * Vector3(std::cos(phi), height, std::sin(phi)));
    }
    return testing::closed_fan(rim_m);
}

/// Pages all around an edge but for a tenth of a turn.
TriangleSoup book_of(std::uint32_t pages) {
    constexpr double kSize_m = 5e-3;
    TriangleSoup soup;
    soup.vertices_m = {{-kSize_m, 0.0, 0.0}, {kSize_m, 0.0, 0.0}};
    for (std::uint32_t i = 0; i < pages; ++i) {
        const double phi = 0.9 * kTurn * i / pages;
        soup.vertices_m.emplace_back(0.0, kSize_m * std::cos(phi), kSize_m * std::sin(phi));
        soup.triangles.push_back({0, 1, 2 + i});
    }
    soup.material_of_triangle.assign(pages, 0);
    soup.materials = {{"page", 0.0}};
    return soup;
}

/// The triangles as they were given, without any preparation.
std::vector<rig::PlainTriangle> given_triangles(const TriangleSoup &soup) {
    std::vector<FacetSource> facets;
    for (std::uint32_t i = 0; i < soup.triangles.size(); ++i) {
        facets.push_back({testing::corners(soup, i), FacetSides::two, i});
    }
    return rig::plain_triangles(facets);
}

TEST(ProxyOnFans, IsWhereTheFanAsGivenLetsItBe) {
    std::mt19937_64 random(1);
    for (const double slope : {0.0, 0.3, -0.3}) {
        for (const double wave : {0.0, 0.2}) {
            const TriangleSoup soup = fan_of(700, slope, wave, 0.0, random);
            const HapticSurface surface(soup);
            ASSERT_EQ(surface.report().graded_fans.all, 1U);
            const std::vector<rig::PlainTriangle> triangles = given_triangles(soup);
            const rig::NearbyTriangles crossings(triangles);
            const rig::BruteForceProxy brute_force(triangles);
            testing::ProbingTip tip(soup, 1);
            Proxy proxy;
            proxy.reset(tip.position_m());
            int settled = 0;
            int unsettled = 0;
            for (int step = 0; step < 600; ++step) {
                const Vector3 tip_m = tip.advance();
                const Contact contact = proxy.update(surface, tip_m);
                const ProxyPath &path = proxy.path();
                for (std::size_t i = 0; i + 1 < path.size(); ++i) {
                    ASSERT_FALSE(crossings.crossed(path[i], path[i + 1])) << slope << " " << step;
                }
                if (!contact.settled) {
                    ++unsettled;
                    ASSERT_LT((contact.x0_m - tip_m).norm(), (path[0] - tip_m).norm());
                } else if (contact.touching && step % 10 == 0) {
                    ++settled;
                    const Vector3 end_m =
                        brute_force.walk(contact.x0_m, tip_m, 0.5 * kClearance_m).point_m;
                    // The clearance that the walk may use up, and what the fan lies off.
                    ASSERT_LT((contact.x0_m - tip_m).norm() - (end_m - tip_m).norm(),
                              3.0 * (0.5 * kClearance_m + kGradingError_m))
                        << slope << " " << wave << " " << step;
                }
            }
            EXPECT_GT(settled, 10);
            EXPECT_LT(unsettled, 30);
        }
    }
}

/// Nothing is known of any motion there within the effort of one update.
TEST(ProxyOnFans, LeavesPlacesWhereHundredsMeet) {
    std::mt19937_64 random(2);
    for (const TriangleSoup &soup : {fan_of(1500, 0.2, 0.0, 0.1, random),
                                     fan_of(1500, -0.2, 0.1, 0.1, random), book_of(1500)}) {
        const HapticSurface surface(soup);
        Proxy proxy;
        proxy.reset({0.0, 0.01, -1e-3});
        int unsettled = 0;
        for (int step = 0; step < 200; ++step) {
            unsettled += proxy.update(surface, {0.0, -1e-3, 0.0}).settled ? 0 : 1;
        }
        const Vector3 pressed_m = proxy.path()[proxy.path().size() - 1];
        EXPECT_GT(unsettled, 0); // not vacuous
        Contact contact;
        int steps = 0;
        do {
            contact = proxy.update(surface, {2e-3, 0.012, -1e-3});
        } while (!contact.settled && ++steps < 50);
        EXPECT_TRUE(contact.settled);
        EXPECT_GT((contact.x0_m - pressed_m).norm(), 1e-3);
    }
}

} // namespace
} // namespace springdrive::contact
