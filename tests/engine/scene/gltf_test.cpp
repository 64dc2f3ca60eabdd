#include "engine/scene/gltf.h"

#include "tests/engine/scene/gltf_builder.h"

#include <cmath>

namespace springdrive::scene {
namespace {

constexpr double kFittedRounding_m = 1e-12; // a few double operations on metres

TEST(Gltf, ASceneWithoutUnitsIsFittedAndCentred) {
    GltfBuilder builder = one_triangle();
    builder.asset = R"({"version": "2.0"})";
    const Scene scene = load(builder);
    // ½ × ¼ units into 60 % of 0.2 × 0.1 m: both axes ask for 0.24 m a unit.
    EXPECT_FALSE(scene.in_metres);
    EXPECT_NEAR(scene.metres_per_unit, 0.24, kFittedRounding_m);
    EXPECT_LT((scene.lower_m - Vector3(-0.06, 0.0, -0.015)).norm(), kFittedRounding_m);
    EXPECT_LT((scene.upper_m - Vector3(0.06, 0.06, -0.015)).norm(), kFittedRounding_m);
    EXPECT_LT((scene.surface.vertices_m[1] - Vector3(0.06, 0.0, -0.015)).norm(), kFittedRounding_m);
    EXPECT_FLOAT_EQ(scene.meshes[0].vertices[1].position_m[0], 0.06F);
    EXPECT_EQ(scene.file.filename(), "scene.gltf");
}

TEST(Gltf, FittingIsTheSameWhateverTheUnitAndPlace) {
    GltfBuilder builder = one_triangle();
    builder.asset = R"({"version": "2.0"})";
    const Scene plain = load(builder);
    builder.nodes = {R"({"mesh": 0, "scale": [1000, 1000, 1000], "translation": [5000, 0, -70]})"};
    const Scene large = load(builder);
    EXPECT_NEAR(large.metres_per_unit * 1000.0, plain.metres_per_unit, kFittedRounding_m);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_LT((large.surface.vertices_m[i] - plain.surface.vertices_m[i]).norm(),
                  kFittedRounding_m);
    }
}

TEST(Gltf, MetresAreTakenAsTheyStandFromAssetOrScene) {
    GltfBuilder builder = one_triangle();
    EXPECT_EQ(load(builder).surface.vertices_m[1], Vector3(0.5, 0, 0));
    builder.asset = R"({"version": "2.0"})";
    builder.scenes = {R"({"nodes": [0], "extras": {"units": "m"}})"};
    const Scene scene = load(builder);
    EXPECT_TRUE(scene.in_metres);
    EXPECT_EQ(scene.metres_per_unit, 1.0);
    EXPECT_EQ(scene.surface.vertices_m[1], Vector3(0.5, 0, 0));
    EXPECT_EQ(scene.upper_m, Vector3(0.5, 0.25, 0));
}

TEST(Gltf, OtherUnitsAreAnotherProgramsAndTheSceneIsFitted) {
    const std::string other = ": left out as another program's; it would have to be 'm' (metres)";
    const auto expect_fitted = [&](const GltfBuilder &builder, const std::string &warning) {
        const Scene scene = load(builder);
        EXPECT_FALSE(scene.in_metres);
        EXPECT_TRUE(has_warning(scene, warning + other)) << warning;
    };
    GltfBuilder builder = one_triangle();
    builder.asset = R"({"version": "2.0", "extras": {"units": "centimeters"}})";
    expect_fitted(builder, "asset: extras.units is 'centimeters'");
    builder.asset = R"({"version": "2.0"})";
    builder.scenes = {R"({"nodes": [0], "extras": {"units": 1}})"};
    expect_fitted(builder, "scene: extras.units is 1");
    builder.scenes = {R"({"nodes": [0], "extras": {"units": null}})"};
    expect_fitted(builder, "scene: extras.units is null");
}

TEST(Gltf, MetresOutsideTheWorkspaceAreWarnedOfAndAbsurdOnesRefused) {
    EXPECT_TRUE(has_warning(load(one_triangle()), "outside the device's workspace"));
    EXPECT_FALSE(has_warning(load(one_triangle(R"("scale": [0.1, 0.1, 0.1])")), "outside"));
    expect_failure(one_triangle(R"("scale": [-4000, 1, 1])"), "reaches 2000 m far");
}

TEST(Gltf, UnusedVerticesDoNotCountForTheFit) {
    GltfBuilder builder = one_triangle();
    builder.asset = R"({"version": "2.0"})";
    const Scene plain = load(builder);
    std::vector<float> with_stray = kTriangle;
    with_stray.insert(with_stray.end(), {1000.0F, 0.0F, 0.0F});
    builder.add_positions(with_stray);
    builder.add_accessor(std::vector<std::uint8_t>{0, 1, 2}, kUnsignedByte, "SCALAR");
    builder.meshes = {R"({"primitives": [{"attributes": {"POSITION": 1}, "indices": 2}]})"};
    EXPECT_EQ(load(builder).metres_per_unit, plain.metres_per_unit);
}

TEST(Gltf, NothingToTouchIsRefused) {
    GltfBuilder builder;
    expect_failure(builder, "has no triangle to touch");
    builder = one_triangle();
    builder.nodes = {R"({"name": "camera"})"};
    expect_failure(builder, "has no triangle to touch");
    builder = one_triangle();
    builder.meshes = {R"({"primitives": [{"attributes": {"POSITION": 0}, "mode": 0}]})"};
    expect_failure(builder, "has no triangle to touch (node 0: 3 points");
    builder = one_triangle();
    builder.scenes = {R"({"nodes": []})"};
    expect_failure(builder, "has no triangle to touch");
}

TEST(Gltf, PrimitivesWithoutPositionsAreLeftOut) {
    GltfBuilder builder = one_triangle(R"("name": "part")");
    builder.meshes = {R"({"primitives": [{"attributes": {}, "indices": 0},
                          {"attributes": {"POSITION": 0}}, {"attributes": {"NORMAL": 0}}]})"};
    const Scene scene = load(builder);
    EXPECT_EQ(scene.surface.triangles.size(), 1U);
    EXPECT_TRUE(has_warning(scene, "node 'part': a primitive without POSITION cannot be touched or "
                                   "drawn"));
    builder.meshes = {R"({"primitives": [{"attributes": {}}]})"};
    EXPECT_EQ(line_of_failure(builder.gltf()),
              "has no triangle to touch (node 'part': a primitive without POSITION cannot be "
              "touched or drawn)");
}

TEST(Gltf, EqualWarningsOnManyNodesAreOneLine) {
    GltfBuilder builder = one_triangle();
    builder.meshes = {R"({"primitives": [{"attributes": {"POSITION": 0}, "targets": [{}]},
                          {"attributes": {"POSITION": 0}, "targets": [{}]}]})"};
    builder.nodes.clear();
    constexpr int kNodes = 5000;
    for (int i = 0; i < kNodes; ++i) {
        builder.nodes.emplace_back(R"({"mesh": 0, "skin": 0})");
    }
    EXPECT_EQ(load(builder).warnings,
              (std::vector<std::string>{
                  "nodes 0, 1, 2 and 4997 more: its skin is left out; it is touched and drawn in "
                  "the pose that it was modelled in",
                  "nodes 0, 1, 2 and 4997 more: its morph targets are left out; it is touched and "
                  "drawn in its base shape",
                  "the scene is in metres and lies partly outside the device's workspace"}));
}

TEST(Gltf, EverythingInOnePointIsRefused) {
    expect_failure(one_triangle(R"("scale": [0, 0, 0])"), "all its triangles lie in one point");
}

TEST(Gltf, AbsurdNumbersOfTrianglesAreRefusedBeforeAnyIsRead) {
    // 70,000 triangles a node, at 300 bytes.
    GltfBuilder builder = one_triangle();
    builder.add_accessor(std::vector<std::uint8_t>(210'000, 7), kUnsignedByte, "SCALAR");
    builder.meshes = {R"({"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]})"};
    builder.nodes.assign(500, R"({"mesh": 0})");
    expect_failure(
        builder,
        "node 409: with it the scene has 28700000 triangles and 1230 vertices, "
        "for which loading needs about 8 GiB of memory; at most 8 GiB are allowed: simplify it");
    builder.nodes.resize(409);
    expect_failure(builder, "index 7 is out of range"); // just few enough to look inside
}

TEST(Gltf, MoreMaterialsThanTrianglesCanNameAreRefused) {
    GltfBuilder builder = one_triangle();
    builder.nodes.assign(65'536, R"({"mesh": 0})");
    EXPECT_EQ(load(builder).surface.material_of_triangle.back(), 65'535);
    builder.nodes.emplace_back(R"({"mesh": 0})");
    expect_failure(builder, "has more than 65536 nodes with triangles");
}

TEST(Gltf, SkinsAndMorphTargetsAreTouchedAtRestAndWarnedOf) {
    GltfBuilder builder = one_triangle(R"("name": "figure", "skin": 0)");
    builder.meshes = {
        R"({"primitives": [{"attributes": {"POSITION": 0}, "targets": [{"POSITION": 0}]}]})"};
    builder.more = R"("skins": [{"joints": [0]}], )";
    const Scene scene = load(builder);
    EXPECT_EQ(scene.surface.vertices_m[1], Vector3(0.5, 0, 0));
    EXPECT_TRUE(has_warning(scene, "node 'figure': its skin is left out"));
    EXPECT_TRUE(has_warning(scene, "node 'figure': its morph targets are left out"));
}

TEST(Gltf, ANameWithLineEndsStillMakesOneLine) {
    expect_failure(one_triangle(R"("name": "a\nb\u001b[2J", "scale": [1])"), "node 'a b [2J'");
}

} // namespace
} // namespace springdrive::scene
