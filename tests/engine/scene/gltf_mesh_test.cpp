// Covers engine/scene/gltf_mesh.cpp and gltf.cpp: what is touched and drawn of a file.
#include "engine/scene/gltf.h"
#include "engine/scene/gltf_mesh.h"
#include "tests/engine/scene/gltf_builder.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace springdrive::scene {
namespace {

/// A ribbon of `count` vertices, no two alike.
std::vector<float> zigzag(int count) {
    std::vector<float> positions;
    for (int i = 0; i < count; ++i) {
        positions.insert(positions.end(), {0.05F * static_cast<float>(i), i % 2 == 0 ? 0.0F : 0.1F,
                                           0.01F * static_cast<float>(i * i)});
    }
    return positions;
}

Scene load_primitive(const std::vector<float> &positions, const std::string &members,
                     GltfBuilder builder = {}) {
    builder.asset = kMetres;
    const int position = builder.add_positions(positions);
    builder.add_mesh(R"("attributes": {"POSITION": )" + std::to_string(position) + "}" + members);
    builder.nodes = {R"({"mesh": 0, "name": "ribbon"})"};
    return load(builder);
}

/// The same triangle may start at any of its corners.
bool same_triangle(const std::array<Vector3, 3> &a, std::array<Vector3, 3> b) {
    for (int turn = 0; turn < 3; ++turn) {
        if (a == b) {
            return true;
        }
        std::rotate(b.begin(), b.begin() + 1, b.end());
    }
    return false;
}

void expect_same_surface(const contact::TriangleSoup &a, const contact::TriangleSoup &b) {
    const auto left = corners_of(a);
    const auto right = corners_of(b);
    ASSERT_EQ(left.size(), right.size());
    for (std::size_t i = 0; i < left.size(); ++i) {
        EXPECT_TRUE(same_triangle(left[i], right[i])) << "triangle " << i;
    }
}

template <typename Index>
Scene load_indexed(const std::vector<Index> &indices, int component_type, int mode) {
    GltfBuilder builder;
    builder.asset = kMetres;
    const int accessor = builder.add_accessor(indices, component_type, "SCALAR");
    return load_primitive(zigzag(7),
                          R"(, "mode": )" + std::to_string(mode) + R"(, "indices": )" +
                              std::to_string(accessor),
                          builder);
}

TEST(GltfPrimitive, StripAndFanAreTheListsThatTheSpecificationSpellsOut) {
    // glTF 2.0, 3.7.2.1: p_i = {v_i, v_(i + 1 + i%2), v_(i + 2 − i%2)} of a strip, and
    // {v_(i+1), v_(i+2), v_0} of a fan, written out for 7 vertices.
    const std::vector<std::uint8_t> strip = {0, 1, 2, 1, 3, 2, 2, 3, 4, 3, 5, 4, 4, 5, 6};
    const std::vector<std::uint8_t> fan = {1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5, 0, 5, 6, 0};
    expect_same_surface(load_primitive(zigzag(7), R"(, "mode": 5)").surface,
                        load_indexed(strip, kUnsignedByte, 4).surface);
    expect_same_surface(load_primitive(zigzag(7), R"(, "mode": 6)").surface,
                        load_indexed(fan, kUnsignedByte, 4).surface);
}

TEST(GltfPrimitive, EveryIndexWidthGivesTheSameSurface) {
    const std::vector<std::uint8_t> narrow = {6, 4, 5, 0, 1, 2, 3, 6, 1};
    const std::vector<std::uint16_t> middle(narrow.begin(), narrow.end());
    const std::vector<std::uint32_t> wide(narrow.begin(), narrow.end());
    for (const int mode : {4, 5, 6}) {
        const Scene expected = load_indexed(narrow, kUnsignedByte, mode);
        EXPECT_EQ(expected.surface.triangles.size(), mode == 4 ? 3U : 7U);
        expect_same_surface(load_indexed(middle, kUnsignedShort, mode).surface, expected.surface);
        expect_same_surface(load_indexed(wide, kUnsignedInt, mode).surface, expected.surface);
    }
}

TEST(GltfPrimitive, PointsAndLinesAreLeftOutByName) {
    const std::array<std::string, 4> expected = {"7 points", "3 line segments", "7 line segments",
                                                 "6 line segments"};
    for (std::size_t mode = 0; mode < expected.size(); ++mode) {
        GltfBuilder builder = one_triangle(R"("name": "solid")");
        const int position = builder.add_positions(zigzag(7));
        builder.add_mesh(R"("mode": )" + std::to_string(mode) + R"(, "attributes": {"POSITION": )" +
                         std::to_string(position) + "}");
        builder.nodes.emplace_back(R"({"mesh": 1, "name": "wire"})");
        const Scene scene = load(builder);
        EXPECT_EQ(scene.surface.triangles.size(), 1U);
        EXPECT_EQ(scene.meshes.size(), 1U);
        EXPECT_EQ(scene.surface.materials.size(), 1U);
        EXPECT_TRUE(
            has_warning(scene, "node 'wire': " + expected[mode] + " cannot be touched or drawn"));
    }
}

TEST(GltfPrimitive, LeftoverVerticesAreSaid) {
    const Scene scene = load_primitive(zigzag(8), "");
    EXPECT_EQ(scene.surface.triangles.size(), 2U);
    EXPECT_TRUE(has_warning(scene, "node 'ribbon': 2 vertices are left over"));
}

TEST(GltfPrimitive, QuantisedPositionsAreScaledAsDeclared) {
    const auto load_short = [](const std::string &extra) {
        GltfBuilder builder;
        builder.asset = kMetres;
        builder.more = R"("extensionsRequired": ["KHR_mesh_quantization"], )";
        const std::vector<std::int16_t> numbers = {0, 0, 0, 32767, 0, 0, 0, -32768, 16384};
        const int position = builder.add_accessor(numbers, kShort, "VEC3", extra);
        builder.add_mesh(R"("attributes": {"POSITION": )" + std::to_string(position) + "}");
        builder.nodes = {R"({"mesh": 0, "scale": [0.001, 0.001, 0.001]})"};
        return load(builder).surface.vertices_m;
    };
    const auto normalised = load_short(R"(, "normalized": true)");
    EXPECT_DOUBLE_EQ(normalised[1].x(), 0.001);
    EXPECT_DOUBLE_EQ(normalised[2].y(), -0.001); // −32768 counts as −1, not less
    EXPECT_DOUBLE_EQ(normalised[2].z(), 0.001 * 16384.0 / 32767.0);
    const auto plain = load_short("");
    EXPECT_DOUBLE_EQ(plain[1].x(), 32.767);
    EXPECT_DOUBLE_EQ(plain[2].y(), -32.768);
}

TEST(GltfPrimitive, RefusesWhatDoesNotFitTogether) {
    const auto failing = [](const std::string &primitive, const std::string &message) {
        GltfBuilder builder = one_triangle(R"("name": "bad")");
        builder.add_accessor(std::vector<float>{0, 0, 1, 0, 0, 1}, kFloat, "VEC3");          // 1
        builder.add_accessor(std::vector<float>{0, 0, 1, 0, 0, 1}, kFloat, "VEC2");          // 2
        builder.add_accessor(std::vector<std::uint16_t>{0, 1, 3}, kUnsignedShort, "SCALAR"); // 3
        builder.add_accessor(std::vector<std::int16_t>{0, 1, 2}, kShort, "SCALAR");          // 4
        builder.meshes = {R"({"primitives": [{)" + primitive + "}]}"};
        expect_failure(builder, message);
        EXPECT_NE(failure_of(builder).find("node 'bad'"), std::string::npos);
    };
    failing(R"("attributes": {"POSITION": 9})", "accessor 9 is not in the file");
    failing(R"("attributes": {"POSITION": -1})", "accessor -1 is not in the file");
    failing(R"("attributes": {"POSITION": 2})", "POSITION has 2 numbers a vertex");
    failing(R"("attributes": {"POSITION": 0, "NORMAL": 1})", "NORMAL has 2 entries for 3");
    failing(R"("attributes": {"POSITION": 0, "TEXCOORD_0": 0})", "TEXCOORD_0 has 3 numbers");
    failing(R"("attributes": {"POSITION": 0, "COLOR_0": 2})", "COLOR_0 has 2 numbers");
    failing(R"("attributes": {"POSITION": 0}, "indices": 3)", "index 3 is out of range");
    failing(R"("attributes": {"POSITION": 0}, "indices": 4)", "indices are scalars");
    failing(R"("attributes": {"POSITION": 0}, "indices": 0)", "indices are scalars");
    failing(R"("attributes": {"POSITION": 0}, "mode": 7)", "mode 7 is unknown");
    failing(R"("attributes": {"POSITION": 0}, "material": 0)", "material 0 is not in the file");
}

TEST(GltfPrimitive, RefusesPositionsThatAreNotFinite) {
    for (const float bad :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
          -std::numeric_limits<float>::infinity()}) {
        GltfBuilder builder = one_triangle();
        std::memcpy(&builder.buffer[std::size_t{4} * 4], &bad, sizeof bad); // y of vertex 1
        expect_failure(builder, "node 0: POSITION of vertex 1 is not finite");
    }
}

constexpr float kFloatRounding = 1e-6F; // of unit vectors and colours

Vector3 normal_of(const VisualVertex &vertex) {
    return {vertex.normal[0], vertex.normal[1], vertex.normal[2]};
}

Vector3 position_of(const VisualVertex &vertex) {
    return {vertex.position_m[0], vertex.position_m[1], vertex.position_m[2]};
}

/// The tetrahedron with unit legs along the axes: volume 1/6.
GltfBuilder tetrahedron(const std::string &node_members) {
    GltfBuilder builder;
    builder.asset = kMetres;
    builder.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
    builder.add_accessor(std::vector<std::uint8_t>{0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3},
                         kUnsignedByte, "SCALAR");
    builder.add_mesh(R"("attributes": {"POSITION": 0}, "indices": 1)");
    builder.nodes = {R"({"mesh": 0, )" + node_members + "}"};
    return builder;
}

TEST(GltfMesh, MirroredNodesAreStillWoundOutwards) {
    for (const char *scale : {"[1, 1, 1]", "[-1, 1, 1]", "[1, -1, -1]", "[-1, -1, -1]"}) {
        const Scene scene = load(tetrahedron(R"("scale": )" + std::string(scale)));
        EXPECT_DOUBLE_EQ(volume_of(scene.surface), 1.0 / 6.0) << scale;
    }
    // A mirror in a parent counts as much as one in the node, and two cancel.
    GltfBuilder builder = tetrahedron(R"("scale": [-1, 1, 1])");
    builder.nodes.emplace_back(R"({"children": [0], "scale": [1, -2, 1]})");
    EXPECT_DOUBLE_EQ(volume_of(load(builder).surface), 2.0 / 6.0);
}

TEST(GltfMesh, MissingNormalsBecomeTheFlatOnesOfEachTriangle) {
    for (const char *scale : {"[1, 1, 1]", "[1, 1, -1]"}) {
        const Scene scene = load(tetrahedron(R"("scale": )" + std::string(scale)));
        const VisualMesh &mesh = scene.meshes.front();
        ASSERT_EQ(mesh.vertices.size(), 12U);
        ASSERT_EQ(mesh.indices.size(), 12U);
        for (std::size_t i = 0; i < 12; i += 3) {
            const Vector3 a = position_of(mesh.vertices[mesh.indices[i]]);
            const Vector3 b = position_of(mesh.vertices[mesh.indices[i + 1]]);
            const Vector3 c = position_of(mesh.vertices[mesh.indices[i + 2]]);
            const Vector3 expected = (b - a).cross(c - a).normalized();
            for (std::size_t k = 0; k < 3; ++k) {
                const Vector3 normal = normal_of(mesh.vertices[mesh.indices[i + k]]);
                EXPECT_LT((normal - expected).norm(), kFloatRounding);
            }
        }
    }
}

GltfBuilder with_normals(const std::vector<float> &normals, const std::string &node_members) {
    GltfBuilder builder = one_triangle(node_members);
    const int normal = builder.add_accessor(normals, kFloat, "VEC3");
    builder.meshes = {R"({"primitives": [{"attributes": {"POSITION": 0, "NORMAL": )" +
                      std::to_string(normal) + "}}]}"};
    return builder;
}

TEST(GltfMesh, NormalsStaySquareToTheSurfaceUnderAnyTransform) {
    // The plane x + y + z = 1, squeezed, mirrored and turned: its normal is M⁻ᵀ (1,1,1), outwards.
    for (const char *scale : {"[2, 1, 1]", "[-2, 1, 1]", "[0.1, -3, 5]", "[-1, -2, -3]"}) {
        GltfBuilder builder =
            with_normals({1, 1, 1, 1, 1, 1, 1, 1, 1},
                         R"("rotation": [0.48, 0.6, 0, 0.64], "scale": )" + std::string(scale));
        const std::vector<float> plane = {1, 0, 0, 0, 1, 0, 0, 0, 1};
        std::memcpy(builder.buffer.data(), plane.data(), 36);
        const VisualMesh mesh = load(builder).meshes.front();
        const Vector3 a = position_of(mesh.vertices[mesh.indices[0]]);
        const Vector3 b = position_of(mesh.vertices[mesh.indices[1]]);
        const Vector3 c = position_of(mesh.vertices[mesh.indices[2]]);
        const Vector3 wound = (b - a).cross(c - a).normalized();
        for (const VisualVertex &vertex : mesh.vertices) {
            EXPECT_LT((normal_of(vertex) - wound).norm(), 10 * kFloatRounding) << scale;
        }
    }
}

TEST(GltfMesh, NormalsAreMadeUnitAndNeverNothing) {
    const VisualMesh mesh =
        load(with_normals({0, 0, 5, 0, 0, 0, NAN, 0, 0}, R"("name": "n")")).meshes.front();
    EXPECT_EQ(mesh.vertices[0].normal, (std::array<float, 3>{0, 0, 1}));
    EXPECT_EQ(mesh.vertices[1].normal, (std::array<float, 3>{0, 1, 0}));
    EXPECT_EQ(mesh.vertices[2].normal, (std::array<float, 3>{0, 1, 0}));
}

TEST(GltfMesh, DegenerateTrianglesAreKept) {
    GltfBuilder builder = one_triangle();
    builder.add_accessor(std::vector<std::uint8_t>{0, 1, 2, 1, 1, 2}, kUnsignedByte, "SCALAR");
    builder.meshes = {R"({"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]})"};
    const Scene scene = load(builder);
    EXPECT_EQ(scene.surface.triangles.size(), 2U);
    EXPECT_EQ(scene.meshes[0].vertices[3].normal, (std::array<float, 3>{0, 1, 0}));
}

TEST(GltfMesh, EveryPrimitiveOfANodeSharesItsMaterial) {
    GltfBuilder builder = one_triangle(R"("extras": {"eta": 0.25})");
    builder.meshes = {R"({"primitives": [{"attributes": {"POSITION": 0}},
                                         {"attributes": {"POSITION": 0}}]})"};
    const Scene scene = load(builder);
    EXPECT_EQ(scene.meshes.size(), 2U);
    ASSERT_EQ(scene.surface.materials.size(), 1U);
    EXPECT_EQ(scene.surface.materials[0].eta, 0.25);
    EXPECT_EQ(scene.surface.material_of_triangle, (std::vector<std::uint16_t>{0, 0}));
    EXPECT_EQ(scene.surface.triangles[1], (std::array<std::uint32_t, 3>{3, 4, 5}));
}

/// The colours of one triangle's vertices, given COLOR_0 and a material.
template <typename Number>
std::vector<std::array<float, 4>> colours(const std::vector<Number> &numbers, int component_type,
                                          const std::string &type, const std::string &material) {
    GltfBuilder builder = one_triangle();
    builder.add_accessor(numbers, component_type, type);
    builder.meshes = {R"({"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 1},
                                          "material": 0}]})"};
    builder.materials = {material};
    const Scene scene = load(builder);
    std::vector<std::array<float, 4>> result;
    for (const VisualVertex &vertex : scene.meshes.front().vertices) {
        result.push_back(vertex.colour);
    }
    return result;
}

const std::string kBlendedMaterial =
    R"({"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 1, 1, 0.5]}})";

TEST(GltfMesh, VertexColoursOfEveryKindMultiplyTheBaseColour) {
    const auto floats =
        colours(std::vector<float>{1, 0.5F, 0, 1, 1, 1, 1, 1, 1}, kFloat, "VEC3", kBlendedMaterial);
    EXPECT_EQ(floats[0], (std::array<float, 4>{0.5F, 0.5F, 0.0F, 0.5F}));
    EXPECT_EQ(floats[1], (std::array<float, 4>{0.5F, 1.0F, 1.0F, 0.5F}));
    // Integers count as fractions, whether or not the file says "normalized".
    const auto shorts =
        colours(std::vector<std::uint16_t>{65535, 13107, 0, 32767, 0, 0, 0, 0, 0, 0, 0, 0},
                kUnsignedShort, "VEC4", kBlendedMaterial);
    EXPECT_FLOAT_EQ(shorts[0][0], 0.5F);
    EXPECT_FLOAT_EQ(shorts[0][1], 0.2F); // 13107 / 65535
    EXPECT_FLOAT_EQ(shorts[0][3], 0.5F * 32767.0F / 65535.0F);
    const auto bytes = colours(std::vector<std::uint8_t>{255, 51, 0, 255, 0, 0, 0, 0, 0, 0, 0, 0},
                               kUnsignedByte, "VEC4", kBlendedMaterial);
    EXPECT_FLOAT_EQ(bytes[0][1], 0.2F);
}

TEST(GltfMesh, OpaqueMaterialsIgnoreAlpha) {
    const auto opaque =
        colours(std::vector<float>{1, 1, 1, 0.25F, 1, 1, 1, 1, 1, 1, 1, 1}, kFloat, "VEC4",
                R"({"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0]}})");
    EXPECT_EQ(opaque[0][3], 1.0F);
}

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
    builder.meshes = {R"({"weights": [0], "primitives": [{"attributes": {"POSITION": 0}},
                          {"attributes": {"POSITION": 0}}]})"};
    builder.more = R"("skins": [{"joints": [0]}], )";
    builder.nodes.clear();
    constexpr int kNodes = 5000;
    for (int i = 0; i < kNodes; ++i) {
        builder.nodes.emplace_back(R"({"mesh": 0, "skin": 0})");
    }
    EXPECT_EQ(load(builder).warnings,
              (std::vector<std::string>{
                  "nodes 0, 1, 2 and 4997 more: has 1 weights for 0 morph targets; those without "
                  "are left out",
                  "nodes 0, 1, 2 and 4997 more: a primitive has no JOINTS_0: its skin does not "
                  "move it",
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

TEST(Gltf, ANameWithLineEndsStillMakesOneLine) {
    expect_failure(one_triangle(R"("name": "a\nb\u001b[2J", "scale": [1])"), "node 'a b [2J'");
}

} // namespace
} // namespace springdrive::scene
