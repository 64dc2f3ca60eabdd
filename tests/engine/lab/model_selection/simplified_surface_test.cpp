// Covers engine/lab/model_selection/simplified_surface.cpp.
#include "engine/lab/model_selection/simplified_surface.h"

#include "engine/contact/proxy/haptic_surface.h"
#include "engine/lab/rig/scenario/test_surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace springdrive::model_selection {
namespace {

constexpr double kRadius_m = 0.05;

/// The largest distance of a triangle's middle from the sphere on which the vertices lie.
double max_sagitta_m(const contact::TriangleSoup &soup) {
    double max_m = 0.0;
    for (const auto &[a, b, c] : soup.triangles) {
        const Vector3 middle_m =
            (soup.vertices_m[a] + soup.vertices_m[b] + soup.vertices_m[c]) / 3.0;
        max_m = std::max(max_m, kRadius_m - middle_m.norm());
    }
    return max_m;
}

TEST(SimplifiedSurface, LeavesASphereClosedAndItsVerticesWhereTheyWere) {
    const contact::TriangleSoup sphere = rig::icosphere(4, kRadius_m); // 5120 triangles
    for (const int divisor : {2, 8, 32}) {
        const contact::TriangleSoup fewer = simplified(sphere, divisor);
        EXPECT_LE(fewer.triangles.size(), sphere.triangles.size() / static_cast<unsigned>(divisor));
        EXPECT_GE(fewer.triangles.size(),
                  sphere.triangles.size() / static_cast<unsigned>(2 * divisor));
        EXPECT_EQ(fewer.material_of_triangle.size(), fewer.triangles.size());
        const contact::MeshReport report = contact::HapticSurface(fewer).report();
        EXPECT_EQ(report.open_edges, 0U);
        EXPECT_EQ(report.closed_components, 1U);
        for (const auto &triangle : fewer.triangles) {
            for (const std::uint32_t corner : triangle) {
                // Icospheres are pushed out in double precision; nothing is moved here.
                ASSERT_NEAR(fewer.vertices_m[corner].norm(), kRadius_m, 1e-15);
            }
        }
    }
}

TEST(SimplifiedSurface, IsFartherFromTheShapeTheFewerItsTriangles) {
    const contact::TriangleSoup sphere = rig::icosphere(5, kRadius_m);
    double last_m = max_sagitta_m(sphere);
    for (const int divisor : {4, 16, 64, 256}) {
        const double sagitta_m = max_sagitta_m(simplified(sphere, divisor));
        EXPECT_GT(sagitta_m, 1.5 * last_m) << divisor; // about 4 for regular triangles
        last_m = sagitta_m;
    }
}

TEST(SimplifiedSurface, WithADivisorOfOneNothingIsLost) {
    const contact::TriangleSoup sphere = rig::icosphere(2, kRadius_m);
    EXPECT_EQ(simplified(sphere, 1).triangles.size(), sphere.triangles.size());
}

TEST(SimplifiedSurface, JoinsFacesThatHaveTheirOwnVertices) {
    const contact::TriangleSoup sphere = rig::icosphere(4, kRadius_m);
    contact::TriangleSoup apart;
    apart.materials = sphere.materials;
    apart.material_of_triangle = sphere.material_of_triangle;
    for (const auto &triangle : sphere.triangles) {
        const auto first = static_cast<std::uint32_t>(apart.vertices_m.size());
        for (const std::uint32_t corner : triangle) {
            apart.vertices_m.push_back(sphere.vertices_m[corner]);
        }
        apart.triangles.push_back({first, first + 1, first + 2});
    }
    EXPECT_EQ(simplified(apart, 8).triangles.size(), simplified(sphere, 8).triangles.size());
    EXPECT_EQ(contact::HapticSurface(simplified(apart, 8)).report().open_edges, 0U);
}

TEST(SimplifiedSurface, KeepsEveryMaterialsTrianglesToItself) {
    contact::TriangleSoup two = rig::icosphere(3, kRadius_m);
    const contact::TriangleSoup other = rig::icosphere(4, 0.02);
    const auto first = static_cast<std::uint32_t>(two.vertices_m.size());
    for (const Vector3 &vertex_m : other.vertices_m) {
        two.vertices_m.emplace_back(vertex_m + Vector3(0.2, 0.0, 0.0));
    }
    for (const auto &[a, b, c] : other.triangles) {
        two.triangles.push_back({first + a, first + b, first + c});
        two.material_of_triangle.push_back(1);
    }
    two.materials.push_back({"other", 0.5});
    const contact::TriangleSoup fewer = simplified(two, 4);
    EXPECT_EQ(std::ranges::count(fewer.material_of_triangle, 0), 1280 / 4);
    EXPECT_EQ(std::ranges::count(fewer.material_of_triangle, 1), 5120 / 4);
    EXPECT_EQ(fewer.materials[1].eta, 0.5);
}

} // namespace
} // namespace springdrive::model_selection
