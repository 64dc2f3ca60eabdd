// Covers engine/lab/rig/scenario/scanned_surface.cpp.
#include "engine/lab/rig/scenario/scanned_surface.h"

#include "engine/contact/proxy/haptic_surface.h"
#include "tests/engine/lab/rig/scenario/soup_measures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace springdrive::rig {
namespace {

constexpr std::size_t kScanTriangles = 50'000;
constexpr std::uint64_t kSeed = 4;

const contact::TriangleSoup &scanned() {
    static const contact::TriangleSoup soup = scanned_surface(kScanTriangles, kSeed);
    return soup;
}

TEST(ScannedSurface, HasAboutAsManyTrianglesAsAsked) {
    for (const std::size_t triangles : {std::size_t{1000}, std::size_t{20'000}, kScanTriangles}) {
        const contact::TriangleSoup soup = scanned_surface(triangles, kSeed);
        EXPECT_NEAR(static_cast<double>(soup.triangles.size()), static_cast<double>(triangles), 10);
        EXPECT_EQ(soup.material_of_triangle.size(), soup.triangles.size());
    }
}

TEST(ScannedSurface, IsTheSameForTheSameSeed) {
    const contact::TriangleSoup again = scanned_surface(kScanTriangles, kSeed);
    EXPECT_EQ(again.vertices_m, scanned().vertices_m);
    EXPECT_EQ(again.triangles, scanned().triangles);
    EXPECT_NE(scanned_surface(kScanTriangles, kSeed + 1).vertices_m, scanned().vertices_m);
}

TEST(ScannedSurface, IsOpenAndWoundAlikeAndTouchedFromBothSides) {
    const testing::EdgeUse use = testing::edge_use(scanned());
    EXPECT_EQ(use.other, 0U);
    EXPECT_GT(use.open, 100U); // the underside's rim alone: 90 mm in edges of about 1 mm
    EXPECT_GT(use.paired, kScanTriangles);
    for (const auto &[a, b, c] : scanned().triangles) {
        const auto &vertices_m = scanned().vertices_m;
        ASSERT_GT(vertices_m[a].cross(vertices_m[b]).dot(vertices_m[c]), 0.0); // outwards, once
    }
    const contact::HapticSurface prepared(scanned());
    EXPECT_EQ(prepared.report().flipped_triangles, 0U);
    EXPECT_EQ(prepared.report().closed_components, 0U);
}

TEST(ScannedSurface, IsSomeCentimetresLargeWithNoiseOfTwentyMicrometres) {
    double sum_m2 = 0.0;
    for (const Vector3 &vertex_m : scanned().vertices_m) {
        ASSERT_GT(vertex_m.norm(), 0.02);
        ASSERT_LT(vertex_m.norm(), 0.07);
        const double noise_m = vertex_m.norm() - scanned_body_radius_m(vertex_m.normalized());
        ASSERT_LT(std::abs(noise_m), 150e-6);
        sum_m2 += noise_m * noise_m;
    }
    const double rms_m = std::sqrt(sum_m2 / static_cast<double>(scanned().vertices_m.size()));
    EXPECT_NEAR(rms_m, 20e-6, 2e-6);
}

TEST(ScannedSurface, HasNoTriangleWellWithinAHole) {
    const std::vector<ScanHole> holes = scan_holes(kSeed);
    EXPECT_EQ(holes.size(), 21U);
    for (const auto &[a, b, c] : scanned().triangles) {
        const auto &vertices_m = scanned().vertices_m;
        const Vector3 direction = (vertices_m[a] + vertices_m[b] + vertices_m[c]).normalized();
        for (const ScanHole &hole : holes) {
            ASSERT_GT(std::acos(std::min(1.0, direction.dot(hole.direction))),
                      hole.half_angle_rad - kMaxRaggedness_rad);
        }
    }
}

TEST(ScannedSurface, IsIrregularUnevenAndHasSlivers) {
    std::vector<double> areas;
    std::map<std::uint32_t, int> valence;
    std::size_t slivers = 0;
    for (std::size_t i = 0; i < scanned().triangles.size(); ++i) {
        const auto &[a, b, c] = scanned().triangles[i];
        const auto &vertices_m = scanned().vertices_m;
        const Vector3 to_b = vertices_m[b] - vertices_m[a];
        areas.push_back(0.5 * to_b.cross(vertices_m[c] - vertices_m[a]).norm());
        slivers += testing::slenderness(scanned(), i) > 30.0 ? 1 : 0;
        for (const std::uint32_t corner : {a, b, c}) {
            ++valence[corner];
        }
    }
    std::ranges::sort(areas);
    EXPECT_GT(areas[areas.size() * 9 / 10], 5.0 * areas[areas.size() / 10]);
    EXPECT_GT(slivers, kScanTriangles / 600);
    EXPECT_LT(slivers, kScanTriangles / 50);
    const auto regular =
        std::ranges::count_if(valence, [](const auto &v) { return v.second == 6; });
    EXPECT_LT(static_cast<double>(regular), 0.5 * static_cast<double>(valence.size()));
}

} // namespace
} // namespace springdrive::rig
