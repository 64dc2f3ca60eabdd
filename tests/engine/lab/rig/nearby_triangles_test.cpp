// Covers engine/lab/rig/nearby_triangles.cpp.
#include "engine/lab/rig/nearby_triangles.h"

#include "tests/engine/contact/proxy/optimality.h"

#include <gtest/gtest.h>

namespace springdrive::rig {
namespace {

using testing::random_vector;

TEST(NearbyTriangles, AreThoseThatALookAtEachFinds) {
    std::mt19937_64 random(1);
    std::size_t all = 0;
    for (int mesh = 0; mesh < 60; ++mesh) {
        contact::TriangleSoup soup = testing::random_soup(random, 1 + mesh * 7, 0.04, 0.02);
        if (mesh % 3 == 0) { // needles that reach through everything, and middles in one place
            for (int i = 0; i < 50; ++i) {
                const Vector3 end = random_vector(random, 0.1);
                testing::add_triangle(soup, {end, -end, end + random_vector(random, 1e-6)});
            }
        }
        std::vector<contact::FacetSource> facets;
        for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
            facets.push_back(
                {testing::corners(soup, i), contact::FacetSides::two, static_cast<unsigned>(i)});
        }
        const std::vector<PlainTriangle> triangles = plain_triangles(facets);
        const NearbyTriangles nearby(triangles);
        for (int i = 0; i < 100; ++i) {
            const Vector3 centre = random_vector(random, 0.06);
            const double radius_m = i % 2 == 0 ? 0.03 : 1e-3;
            const std::vector<std::size_t> found = nearby.within(centre, radius_m);
            ASSERT_TRUE(std::ranges::is_sorted(found));
            std::vector<std::size_t> expected;
            for (std::size_t t = 0; t < triangles.size(); ++t) {
                if (triangles[t].bounds().exteriorDistance(centre) <= radius_m) {
                    expected.push_back(t);
                }
                // Whatever is nearer than the radius is among them.
                if (testing::distance_to_triangle(triangles[t].corners_m, centre) < radius_m) {
                    ASSERT_TRUE(std::ranges::binary_search(found, t));
                }
            }
            ASSERT_EQ(found, expected);
            all += found.size();
        }
    }
    EXPECT_GT(all, 10'000U); // not vacuous
    EXPECT_TRUE(NearbyTriangles({}).within(Vector3::Zero(), 1.0).empty());
}

} // namespace
} // namespace springdrive::rig
