#include "engine/scene/gltf_mesh.h"

#include "tests/engine/scene/gltf_builder.h"

#include <Eigen/Geometry>

#include <cmath>

namespace springdrive::scene {
namespace {

constexpr float kFloatRounding = 1e-6F; // of unit vectors and colours

Vector3 normal_of(const VisualVertex &vertex) {
    return {vertex.normal[0], vertex.normal[1], vertex.normal[2]};
}

Vector3 position_of(const VisualVertex &vertex) {
    return {vertex.position_m[0], vertex.position_m[1], vertex.position_m[2]};
}

/// Twice the volume's triple: six times what the triangles enclose, positive when wound outwards.
double six_volumes(const contact::TriangleSoup &surface) {
    double sum = 0.0;
    for (const auto &[a, b, c] : corners_of(surface)) {
        sum += a.dot(b.cross(c));
    }
    return sum;
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
        EXPECT_DOUBLE_EQ(six_volumes(scene.surface), 1.0) << scale;
    }
    // A mirror in a parent counts as much as one in the node, and two cancel.
    GltfBuilder builder = tetrahedron(R"("scale": [-1, 1, 1])");
    builder.nodes.emplace_back(R"({"children": [0], "scale": [1, -2, 1]})");
    EXPECT_DOUBLE_EQ(six_volumes(load(builder).surface), 2.0);
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

TEST(GltfMesh, WithoutMaterialItIsWhiteAndSingleSided) {
    const VisualMesh mesh = load(one_triangle()).meshes.front();
    EXPECT_EQ(mesh.vertices[0].colour, (std::array<float, 4>{1, 1, 1, 1}));
    EXPECT_FALSE(mesh.double_sided);
    EXPECT_EQ(mesh.texture, -1);
}

} // namespace
} // namespace springdrive::scene
