// Covers engine/lab/rig/scenario/machined_surface.cpp.
#include "engine/lab/rig/scenario/machined_surface.h"

#include "engine/contact/proxy/haptic_surface.h"
#include "tests/engine/lab/rig/scenario/soup_measures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

namespace springdrive::rig {
namespace {

constexpr std::size_t kPartTriangles = 100'000;

const contact::TriangleSoup &machined() {
    static const contact::TriangleSoup soup = machined_surface(kPartTriangles);
    return soup;
}

TEST(MachinedSurface, HasAboutAsManyTrianglesAsAsked) {
    for (const std::size_t triangles : {1000U, 1280U, 5000U, 20'000U, 100'000U, 300'000U}) {
        const contact::TriangleSoup soup = machined_surface(triangles);
        const auto wanted = static_cast<double>(triangles);
        EXPECT_NEAR(static_cast<double>(soup.triangles.size()), wanted,
                    triangles < 20'000 ? 0.06 * wanted : 2e-3 * wanted);
        EXPECT_EQ(soup.material_of_triangle.size(), soup.triangles.size());
    }
}

TEST(MachinedSurface, IsClosedWoundOutwardsAndTouchedFromOutside) {
    for (const std::size_t triangles : {std::size_t{1000}, kPartTriangles}) {
        const contact::TriangleSoup soup = machined_surface(triangles);
        EXPECT_TRUE(testing::is_closed(soup));
        EXPECT_EQ(soup.triangles.size(), 2 * soup.vertices_m.size() - 4); // Euler, no vertex unused
        EXPECT_GT(testing::volume_m3(soup), 0.0);
    }
    const contact::HapticSurface prepared(machined());
    EXPECT_EQ(prepared.report().triangles_kept, machined().triangles.size());
    EXPECT_EQ(prepared.report().components, 1U);
    EXPECT_EQ(prepared.report().closed_components, 1U);
}

TEST(MachinedSurface, HasTheVolumeOfItsParts) {
    // The block less its rounded edges (1 - π/4 of r², along 48 mm) and corners, and the shafts; of
    // the foot's fillet and the end's rounding by Pappus, with the centroid of what is left of a
    // square beside a quarter disc, 0.2234 r from its sides.
    constexpr double kPi = std::numbers::pi;
    constexpr double kLeft = 1.0 - 0.25 * kPi;
    const double block = 50.0 * 50.0 * 50.0 - 12.0 * 48.0 * kLeft - 8.0 * (1.0 - kPi / 6.0);
    const double shaft = kPi * 18.0 * 18.0 * 20.0;
    const double foot = kLeft * 1.5 * 1.5 * 2.0 * kPi * (18.0 + 0.2234 * 1.5);
    const double end = kLeft * 2.0 * kPi * (18.0 - 0.2234);
    const double exact = block + 2.0 * (shaft + foot - end);
    const auto error = [&](const contact::TriangleSoup &soup) {
        return std::abs(1e9 * testing::volume_m3(soup) - exact);
    };
    const double coarse = error(machined());
    EXPECT_LT(coarse, 1e-4 * exact);
    EXPECT_LT(error(machined_surface(1'000'000)),
              coarse / 3.5); // second order: fillets twice as fine
}

TEST(MachinedSurface, HasItsCornersOnTheTrueShape) {
    Vector3 largest_m = Vector3::Zero();
    for (const Vector3 &vertex_m : machined().vertices_m) {
        ASSERT_NEAR(vertex_m.norm(), machined_body_radius_m(vertex_m.normalized()), 1e-12);
        largest_m = largest_m.cwiseMax(vertex_m.cwiseAbs());
    }
    EXPECT_NEAR((largest_m - Vector3(45e-3, 25e-3, 25e-3)).norm(), 0.0, 1e-12);
}

TEST(MachinedSurface, HasNeedlesFansAndFlatFacesOfTwoTriangles) {
    const contact::TriangleSoup soup = machined_surface(1'000'000);
    std::size_t needles = 0;
    std::size_t large = 0;
    double most_slender = 0.0;
    std::map<std::uint32_t, std::size_t> valence;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        const double slender = testing::slenderness(soup, i);
        most_slender = std::max(most_slender, slender);
        needles += slender > 1000.0 ? 1 : 0;
        const auto &[a, b, c] = soup.triangles[i];
        const Vector3 to_b = soup.vertices_m[b] - soup.vertices_m[a];
        const Vector3 to_c = soup.vertices_m[c] - soup.vertices_m[a];
        large += to_b.cross(to_c).norm() > 0.04 * 0.04 ? 1 : 0;
        for (const std::uint32_t corner : {a, b, c}) {
            ++valence[corner];
        }
    }
    EXPECT_EQ(large, 8U);
    EXPECT_GT(needles, 50'000U);
    EXPECT_GT(most_slender, 6000.0);
    EXPECT_LT(most_slender, 15'000.0);
    std::size_t fans = 0;
    for (const auto &[vertex, triangles] : valence) {
        fans += triangles > 2500 ? 1 : 0;
    }
    EXPECT_EQ(fans, 10U); // the ends', and the corners of the two faces with a shaft
}

} // namespace
} // namespace springdrive::rig
