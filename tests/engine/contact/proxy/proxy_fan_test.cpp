// Covers what engine/contact/proxy does where hundreds of triangles meet: fans that were graded,
// and those that were not.
#include "engine/contact/mesh/fan_grading.h"
#include "engine/contact/proxy/proxy.h"
#include "engine/lab/rig/brute_force_proxy.h"
#include "engine/lab/rig/plain_triangles.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/support/hard_meshes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

namespace springdrive::contact {
namespace {

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
