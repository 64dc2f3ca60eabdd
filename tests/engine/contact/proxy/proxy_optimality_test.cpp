// Covers engine/contact/proxy/proxy_solver.cpp and engine/contact/proxy/proxy.cpp: wherever the
// proxy rests, no point nearer to the tip can be reached, and its path crosses no surface.
#include "engine/contact/proxy/proxy.h"

#include "tests/engine/contact/proxy/optimality.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <cmath>

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
    Vector3 tip = random_vector(random, how.extent_m);
    proxy.reset(tip);
    // A start nearer than the reach keeps its distance; only from outside is the full reach kept.
    if (testing::distance_to_soup(how.soup, tip) < how.reach_m) {
        return;
    }
    Vector3 heading = random_direction(random);
    for (int i = 0; i < how.steps; ++i) {
        heading = (heading + 0.5 * random_direction(random)).normalized();
        tip += how.step_m * heading;
        if (tip.norm() > how.extent_m) {
            heading = -tip.normalized();
        }
        const Contact contact = proxy.update(surface, tip);
        // Round a curved offset the last micrometre may take more than one tick.
        const bool is_curved = how.reach_m > kClearance_m;
        ASSERT_TRUE(contact.settled || is_curved);
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
        ASSERT_NEAR(testing::winding_number(how.soup, Vector3(0.2, 0.1, 0.0)), 0.0, 1e-9);
        const HapticSurface surface(how.soup);
        // From outside, in steps that a hand makes; then conditions and side of every step.
        Proxy proxy;
        Vector3 tip = 0.06 * random_direction(random);
        proxy.reset(tip);
        Vector3 heading = -tip.normalized();
        for (int i = 0; i < 60; ++i) {
            tip += 2e-3 * heading;
            heading = (heading + 0.5 * random_direction(random)).normalized();
            if (tip.norm() > 0.05) {
                heading = -tip.normalized();
            }
            const Contact contact = proxy.update(surface, tip);
            met.unsettled += contact.settled ? 0 : 1;
            ASSERT_NEAR(testing::winding_number(how.soup, contact.x0_m), 0.0, 1e-3) << mesh;
            if (contact.touching) {
                ++met.touching;
                met.edges += contact.active_constraints > 1 ? 1 : 0;
                const std::vector<Vector3> normals =
                    testing::pushes(how.soup, contact.x0_m, kClearance_m, 1e-10);
                if (contact.settled) {
                    ASSERT_LT(testing::unexplained_m(contact.x0_m - tip, normals), kHolds_m)
                        << "mesh " << mesh << " step " << i;
                } else {
                    ASSERT_LT((contact.x0_m - tip).norm(), (proxy.path()[0] - tip).norm());
                }
            }
        }
    }
    EXPECT_GT(met.touching, 3000);
    EXPECT_GT(met.edges, 300);
    // Steps of 2 mm, deep within, may take more than an update has.
    EXPECT_LT(met.unsettled, met.touching / 200);
}

} // namespace
} // namespace springdrive::contact
