// Covers engine/contact/mesh/facet_boxes.cpp.
#include "engine/contact/mesh/facet_boxes.h"

#include "tests/engine/contact/mesh/soups.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace springdrive::contact {
namespace {

using testing::random_vector;

FacetSource random_facet(std::mt19937_64 &random, double size_m, double width_m) {
    FacetSource facet;
    facet.corners_m[0] = random_vector(random, 0.1);
    facet.corners_m[1] = facet.corners_m[0] + random_vector(random, size_m);
    facet.corners_m[2] = facet.corners_m[1] + random_vector(random, width_m);
    return facet;
}

TEST(FacetBoxes, CoverTheirFacets) {
    std::mt19937_64 random(1);
    std::vector<FacetSource> facets;
    for (int i = 0; i < 300; ++i) {
        facets.push_back(random_facet(random, 0.02, i % 3 == 0 ? 0.02 : 1e-5));
        facets.back().is_crowded = i % 2 == 0;
    }
    const FacetBoxes found = boxes_of(facets);
    ASSERT_EQ(found.boxes_m.size(), found.facet_of_box.size());
    EXPECT_GT(found.boxes_m.size(), 2 * facets.size());
    std::vector<std::vector<Eigen::AlignedBox3d>> boxes_of_facet(facets.size());
    for (std::size_t i = 0; i < found.boxes_m.size(); ++i) {
        boxes_of_facet[found.facet_of_box[i]].push_back(found.boxes_m[i]);
    }
    std::uniform_real_distribution<double> part(0.0, 1.0);
    for (std::size_t i = 0; i < facets.size(); ++i) {
        const auto &[a, b, c] = facets[i].corners_m;
        for (int sample = 0; sample < 300; ++sample) {
            const double along = sample % 10 == 0 ? 1.0 : part(random);
            const double across = sample % 7 == 0 ? 0.0 : part(random);
            const Vector3 point_m = a + along * (b - a + across * (c - b));
            // Round-off of the point itself.
            ASSERT_TRUE(std::ranges::any_of(boxes_of_facet[i], [&](const auto &box) {
                return box.exteriorDistance(point_m) < 1e-16;
            })) << i;
        }
    }
}

TEST(FacetBoxes, AreOneForEachThatFillsItsOwn) {
    const TriangleSoup sphere = testing::icosphere(4, 0.05);
    std::vector<FacetSource> facets;
    for (std::size_t i = 0; i < sphere.triangles.size(); ++i) {
        facets.push_back({testing::corners(sphere, i)});
    }
    const FacetBoxes found = boxes_of(facets);
    ASSERT_EQ(found.boxes_m.size(), facets.size());
    for (std::uint32_t i = 0; i < facets.size(); ++i) {
        EXPECT_EQ(found.facet_of_box[i], i);
        Eigen::AlignedBox3d box;
        for (const Vector3 &corner_m : facets[i].corners_m) {
            box.extend(corner_m);
        }
        EXPECT_TRUE(found.boxes_m[i].isApprox(box, 0.0));
    }
}

/// Of a long thin facet that lies across the axes, what its boxes hold that is not near it.
TEST(FacetBoxes, OfAnObliqueNeedleHoldLittleElse) {
    FacetSource needle;
    needle.corners_m = {Vector3(0, 0, 0), Vector3(0.02, 0.02, 0.02), Vector3(0.02, 0.02, 0.02001)};
    const FacetBoxes found = boxes_of({needle});
    double volume_m3 = 0.0;
    for (const Eigen::AlignedBox3d &box : found.boxes_m) {
        volume_m3 += box.volume();
    }
    EXPECT_GT(found.boxes_m.size(), 50U);
    EXPECT_LT(found.boxes_m.size(), 2000U);
    EXPECT_LT(volume_m3, 1e-3 * 8e-6);
}

} // namespace
} // namespace springdrive::contact
