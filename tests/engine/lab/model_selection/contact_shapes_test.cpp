// Covers engine/lab/model_selection/contact_shapes.cpp.
#include "engine/lab/model_selection/contact_shapes.h"

#include "base/input_error.h"
#include "tests/engine/lab/model_selection/model_settings.h"
#include "tests/engine/scene/gltf_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

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

} // namespace
} // namespace springdrive::model_selection
