// Covers engine/lab/model_selection/contact_shapes.cpp.
#include "engine/lab/model_selection/contact_shapes.h"

#include "base/input_error.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "tests/engine/lab/model_selection/model_settings.h"
#include "tests/engine/scene/gltf_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace springdrive::model_selection {
namespace {

using Kind = ContactShape::Kind;

bool has(const std::vector<ContactShape> &shapes, Kind kind) {
    return std::ranges::find(shapes, kind, &ContactShape::kind) != shapes.end();
}

TEST(ContactShapes, OfASphereRunFromThePrimitiveToWhatIsGiven) {
    const scene::Scene scene = testing::own_scene("sphere");
    const std::vector<ContactShape> shapes = contact_shapes_of(scene);
    EXPECT_EQ(shapes.front().kind, Kind::primitives);
    EXPECT_EQ(shapes.back(), ContactShape{});
    for (std::size_t i = 1; i + 2 < shapes.size(); ++i) {
        EXPECT_EQ(shapes[i].divisor, 2 * shapes[i + 1].divisor);
    }
    EXPECT_EQ(haptic_surface_of(scene, shapes.front()).shapes().size(), 1U);
    EXPECT_EQ(haptic_surface_of(scene, shapes.front()).report().triangles_given, 0U);
    EXPECT_LE(haptic_surface_of(scene, {Kind::simplified, 8}).report().triangles_given,
              20'480U / 8);
    EXPECT_EQ(haptic_surface_of(scene, {}).report().triangles_given, 20'480U);
}

TEST(ContactShapes, EveryNodeThatIsAPrimitiveBecomesOneWithItsMaterial) {
    const scene::Scene scene = testing::own_scene("compliance");
    const contact::HapticSurface surface = haptic_surface_of(scene, {Kind::primitives, 1});
    constexpr std::array kEta{0.0, 0.25, 0.5, 0.75, 0.9}; // as the scene's captions say
    ASSERT_EQ(surface.shapes().size(), kEta.size());
    for (std::uint16_t i = 0; i < kEta.size(); ++i) {
        EXPECT_EQ(surface.shapes()[i].material(), i);
        EXPECT_TRUE(std::holds_alternative<contact::Box>(surface.shapes()[i].size()));
        EXPECT_EQ(surface.materials()[i].eta, kEta[i]);
    }
}

TEST(ContactShapes, ShapesThatASceneLacksAreNeitherOfferedNorMade) {
    const scene::Scene scene = testing::own_scene("stepped_block");
    const std::vector<ContactShape> shapes = contact_shapes_of(scene);
    EXPECT_FALSE(has(shapes, Kind::primitives));
    EXPECT_FALSE(has(shapes, Kind::flat));
    EXPECT_THROW(static_cast<void>(haptic_surface_of(scene, {Kind::primitives, 1})), InputError);
    EXPECT_THROW(static_cast<void>(haptic_surface_of(scene, {Kind::flat, 1})), InputError);
}

TEST(ContactShapes, ASmoothSceneHasItsFlatTrianglesToo) {
    scene::GltfBuilder builder;
    const int positions = builder.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
    // Diverging normals, as on a dome.
    const int normals =
        builder.add_positions({-0.3F, -0.3F, 0.9F, 0.42F, -0.2F, 0.88F, -0.2F, 0.42F, 0.88F});
    builder.add_mesh(R"("attributes": {"POSITION": )" + std::to_string(positions) +
                     R"(, "NORMAL": )" + std::to_string(normals) + "}");
    builder.nodes = {R"({"mesh": 0, "extras": {"smooth": true}})"};
    const scene::Scene scene = scene::load(builder);
    ASSERT_EQ(scene.flat_surface.triangles.size(), 1U);
    EXPECT_GT(scene.surface.triangles.size(), 10U);
    EXPECT_TRUE(has(contact_shapes_of(scene), Kind::flat));
    EXPECT_EQ(haptic_surface_of(scene, {Kind::flat, 1}).report().triangles_given, 1U);
    // The corners of a curved patch are unchanged: both surfaces have the same placement.
    for (const Vector3 &corner_m : scene.flat_surface.vertices_m) {
        const auto &bent = scene.surface.vertices_m;
        EXPECT_TRUE(std::ranges::any_of(
            bent, [&](const Vector3 &v) { return (v - corner_m).norm() < 1e-12; }));
    }
    EXPECT_TRUE(testing::own_scene("plate").flat_surface.triangles.empty());
}

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
