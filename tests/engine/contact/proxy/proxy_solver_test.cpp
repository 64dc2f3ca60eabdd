// Covers engine/contact/proxy/proxy_solver.cpp where facets and shapes lie beside each other;
// proxy_*_test.cpp cover the rest.
#include "engine/contact/proxy/proxy.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/support/surfaces.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <random>

namespace springdrive::contact {
namespace {

/// How much farther from the tip a proxy may end: it steps over ridges of up to 10 µm and descends
/// on their other side.
constexpr double kJump_m = 1.2e-5;

/// A box that protrudes from the top of another. In their crease, an extrapolated slide on one of
/// them once ended 35 mm away around an edge.
TEST(ProxySolver, IsNotCarriedAwayFromTheTipInACrease) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() =
        Vector3(-0.016851951473135212, 0.01693078811656986, -0.0043772161063318181);
    pose.linear() << 0.18458380798980045, -0.38106674033730736, 0.90593430072863645, //
        0.34153266664254511, -0.83945673057696568, -0.42269118172143555,             //
        0.92156619699510278, 0.38742810545665202, -0.024803379976381601;
    const HapticSurface surface(
        testing::box_soup({-0.04, -0.05, -0.04}, {0.04, 0.0, 0.04}),
        {AnalyticShape(Box{{0.0059338335564660593, 0.013667825344417399, 0.019736503283795708}},
                       pose, 0)});
    const Vector3 from_m(-0.0058666682528241785, 0.00059118778190269533, 0.0059168305426440648);
    const Vector3 tip_m(-0.0070584584738168331, -0.0016894539568893206, 0.00076325675554547614);
    Proxy proxy;
    proxy.reset(from_m);
    const Contact contact = proxy.update(surface, tip_m);
    EXPECT_TRUE(contact.settled);
    EXPECT_LT((contact.x0_m - tip_m).norm(), (from_m - tip_m).norm());
    for (const Vector3 &place_m : proxy.path()) {
        EXPECT_LE((place_m - tip_m).norm(), (from_m - tip_m).norm() + kJump_m);
    }
}

TEST(ProxySolver, NeverEndsFartherFromTheTipThanItBegan) {
    constexpr int kTicks = 600;
    constexpr double kStep_m = 7e-4;
    constexpr double kDeepest_m = 6e-3;
    constexpr std::array kReaches_m{kClearance_m, 1e-3};
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        std::mt19937_64 random(seed);
        Eigen::Isometry3d pose(
            Eigen::AngleAxisd(static_cast<double>(seed), testing::random_direction(random)));
        pose.translation() = testing::random_vector(random, 0.03);
        const AnalyticShape shape(Cylinder{0.02, 0.02}, pose, 0);
        const HapticSurface surface(testing::bumpy_sphere(3, 0.03), {shape});
        Proxy proxy(kReaches_m[seed % 2]);
        Vector3 tip_m = 0.08 * testing::random_direction(random);
        proxy.reset(tip_m);
        Vector3 heading = -tip_m.normalized();
        Vector3 before_m = tip_m;
        for (int tick = 0; tick < kTicks; ++tick) {
            heading = (heading + 0.2 * testing::random_direction(random)).normalized();
            if ((before_m - tip_m).norm() > kDeepest_m || tip_m.norm() > 0.08) {
                heading = ((tip_m.norm() > 0.08 ? Vector3::Zero() : before_m) - tip_m).normalized();
            }
            tip_m += kStep_m * heading;
            const Contact contact = proxy.update(surface, tip_m);
            ASSERT_LE((contact.x0_m - tip_m).norm(), (before_m - tip_m).norm() + kJump_m)
                << "seed " << seed << ", tick " << tick;
            before_m = contact.x0_m;
        }
    }
}

} // namespace
} // namespace springdrive::contact
