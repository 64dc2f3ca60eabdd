#include "engine/scene/smooth_nodes.h"

#include "engine/contact/mesh/mesh_preparation.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/engine/scene/gltf_builder.h"

#include <cmath>

namespace springdrive::scene {
namespace {

std::vector<float> floats(const std::vector<Vector3> &vectors) {
    std::vector<float> numbers;
    for (const Vector3 &v : vectors) {
        for (const double number : {v.x(), v.y(), v.z()}) {
            numbers.push_back(static_cast<float>(number));
        }
    }
    return numbers;
}

/// An icosphere of radius 0.04 m in metres, accessors 0 and 1 its positions and normals, 2 its
/// indices; one node.
GltfBuilder ball(const std::string &node_members, int level = 1) {
    contact::TriangleSoup soup = springdrive::testing::icosphere(level, 0.04);
    GltfBuilder builder;
    builder.asset = kMetres;
    builder.add_positions(floats(soup.vertices_m));
    for (Vector3 &vertex : soup.vertices_m) {
        vertex.normalize();
    }
    builder.add_positions(floats(soup.vertices_m));
    std::vector<std::uint32_t> indices;
    for (const auto &triangle : soup.triangles) {
        indices.insert(indices.end(), triangle.begin(), triangle.end());
    }
    builder.add_accessor(indices, kUnsignedInt, "SCALAR");
    builder.add_mesh(R"("attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2)");
    builder.nodes = {R"({"mesh": 0)" + node_members + "}"};
    return builder;
}

const std::string kSmoothBall = R"(, "name": "ball", "extras": {"smooth": true})";

TEST(SmoothNodes, EyeAndHandGetTheSameCurvedSurface) {
    const Scene scene = load(ball(kSmoothBall));
    ASSERT_EQ(scene.meshes.size(), 1U);
    const VisualMesh &drawn = scene.meshes[0];
    const contact::TriangleSoup &touched = scene.surface;
    ASSERT_GT(touched.triangles.size(), 10'000U);
    ASSERT_EQ(drawn.indices.size(), 3 * touched.triangles.size());
    for (std::size_t i = 0; i < drawn.indices.size(); ++i) {
        const std::uint32_t corner = touched.triangles[i / 3][i % 3];
        const VisualVertex &vertex = drawn.vertices[drawn.indices[i]];
        for (int c = 0; c < 3; ++c) {
            ASSERT_EQ(vertex.position_m[static_cast<std::size_t>(c)],
                      static_cast<float>(touched.vertices_m[corner][c]));
        }
        const Vector3 point = touched.vertices_m[corner];
        ASSERT_NEAR(point.norm(), 0.04, 1e-6);
        const Vector3 normal(vertex.normal[0], vertex.normal[1], vertex.normal[2]);
        ASSERT_GT(normal.dot(point.normalized()), 1.0 - 2e-6); // 0.1°
    }
    EXPECT_FALSE(has_warning(scene, "ball")); // as smooth as it should be
}

TEST(SmoothNodes, OthersKeepTheirTriangles) {
    EXPECT_EQ(load(ball("")).surface.triangles.size(), 80U);
    EXPECT_EQ(load(ball(R"(, "extras": {"smooth": false})")).surface.triangles.size(), 80U);
    GltfBuilder builder = ball(kSmoothBall);
    builder.nodes.emplace_back(R"({"mesh": 0, "name": "facets"})");
    const Scene scene = load(builder);
    EXPECT_EQ(scene.meshes[1].indices.size(), 240U);
    EXPECT_GT(scene.meshes[0].indices.size(), 30'000U);
}

TEST(SmoothNodes, AMirroredBallIsStillRoundAndFacesOutwards) {
    const Scene scene = load(ball(kSmoothBall + R"(, "scale": [1, 1, -1])"));
    for (const auto &[a, b, c] : corners_of(scene.surface)) {
        ASSERT_GT((b - a).cross(c - a).dot(a), 0.0);
    }
    for (const VisualVertex &vertex : scene.meshes[0].vertices) {
        ASSERT_GT(vertex.normal[0] * vertex.position_m[0] +
                      vertex.normal[1] * vertex.position_m[1] +
                      vertex.normal[2] * vertex.position_m[2],
                  0.0F);
    }
}

TEST(SmoothNodes, ColoursAndTextureCoordinatesRunLinearlyOverAPatch) {
    // On a ball, colour and texture coordinates that are linear in where the triangle's flat point
    // would be; a patch of one triangle shows it: (r, g) = (u, v) = weights of corners 1 and 2.
    GltfBuilder builder;
    builder.asset = kMetres;
    builder.add_positions({0.04F, 0, 0, 0, 0.04F, 0, 0, 0, 0.04F});
    builder.add_positions({1, 0, 0, 0, 1, 0, 0, 0, 1});
    builder.add_positions({0, 0, 1, 1, 0, 1, 0, 1, 1}); // colours
    builder.add_accessor(std::vector<float>{0, 0, 1, 0, 0, 1}, kFloat, "VEC2");
    builder.add_mesh(
        R"("attributes": {"POSITION": 0, "NORMAL": 1, "COLOR_0": 2, "TEXCOORD_0": 3})");
    builder.nodes = {R"({"mesh": 0, "extras": {"smooth": true}})"};
    const Scene scene = load(builder);
    const VisualMesh &mesh = scene.meshes[0];
    ASSERT_GT(mesh.vertices.size(), 100U);
    double sum = 0.0;
    for (const VisualVertex &vertex : mesh.vertices) {
        EXPECT_EQ(vertex.colour[0], vertex.texture_coordinate[0]);
        EXPECT_EQ(vertex.colour[1], vertex.texture_coordinate[1]);
        EXPECT_FLOAT_EQ(vertex.colour[2], 1.0F);
        // By symmetry the patch's weights order its coordinates: the heavier corner is nearer.
        const float w0 = 1.0F - vertex.colour[0] - vertex.colour[1];
        EXPECT_EQ(w0 > vertex.colour[0] + 1e-6F,
                  vertex.position_m[0] > vertex.position_m[1] + 1e-9F);
        sum += static_cast<double>(vertex.colour[0]);
    }
    EXPECT_NEAR(sum / static_cast<double>(mesh.vertices.size()), 1.0 / 3.0, 1e-6);
}

TEST(SmoothNodes, PrimitivesOfOneNodeStayJoined) {
    // The two halves of a ball, each a primitive with indices of its own: the northern one of 40
    // triangles is cut as the other is, and they meet point by point.
    GltfBuilder builder = ball(kSmoothBall);
    builder.accessors.pop_back();
    const std::string head =
        R"({"bufferView": 2, "componentType": 5125, "type": "SCALAR", "count": )";
    builder.accessors.push_back(head + "60}");
    builder.accessors.push_back(head + R"(180, "byteOffset": 240})");
    const std::string vertices = R"("attributes": {"POSITION": 0, "NORMAL": 1}, "indices": )";
    builder.meshes = {R"({"primitives": [{)" + vertices + "2}, {" + vertices + "3}]}"};
    const Scene parts = load(builder);
    const Scene whole = load(ball(kSmoothBall));
    ASSERT_EQ(parts.meshes.size(), 2U);
    ASSERT_EQ(parts.surface.triangles.size(), whole.surface.triangles.size());
    for (std::size_t i = 0; i < parts.surface.vertices_m.size(); ++i) {
        // Which end an edge is computed from depends on the numbering, and so do its last places.
        ASSERT_LT((parts.surface.vertices_m[i] - whole.surface.vertices_m[i]).norm(), 1e-16);
    }
    EXPECT_EQ(contact::prepare_mesh(parts.surface).report.open_edges, 0U);
}

TEST(SmoothNodes, MeshesWithoutNormalsStayFlatAndThoseOfLengthZeroAreRefused) {
    const Scene flat = load(one_triangle(R"("name": "X", "extras": {"smooth": true})"));
    EXPECT_EQ(flat.surface.triangles.size(), 1U);
    EXPECT_TRUE(has_warning(flat,
                            "node 'X': extras.smooth is left out: it needs normals; export it "
                            "with them"));
    GltfBuilder builder = ball(kSmoothBall);
    const std::string zeros(12, '\0'); // the normal of vertex 2
    builder.buffer.replace(42 * 12 + 24, 12, zeros);
    expect_failure(builder, "node 'ball': extras.smooth needs normals, but that of vertex 2 has no "
                            "direction");
}

TEST(SmoothNodes, ManyShareTheAllowanceAndSayHowFarTheyGot) {
    GltfBuilder builder = ball(kSmoothBall);
    builder.nodes.assign(30, builder.nodes[0]); // 30 × 177,000 triangles would be wanted
    const Scene scene = load(builder);
    EXPECT_LE(scene.surface.triangles.size(), gltf::kMaxCurvedTriangles);
    EXPECT_GT(scene.surface.triangles.size(), gltf::kMaxCurvedTriangles / 2);
    EXPECT_TRUE(has_warning(
        scene, "nodes 'ball', 'ball', 'ball' and 27 more: its 62720 curved facets still "
               "differ by up to 0.8"));
    EXPECT_TRUE(has_warning(scene, "degrees from their neighbours, instead of 0.5"));
}

TEST(SmoothNodes, WhatIsFineEnoughOrTooLargeStaysAsItIs) {
    EXPECT_EQ(load(ball(kSmoothBall, 6)).surface.triangles.size(), 81'920U * 4U); // 0.7° as it is
    GltfBuilder builder = one_triangle(R"("name": "large", "extras": {"smooth": true})");
    builder.add_accessor(std::vector<std::uint8_t>(1'500'003, 0), kUnsignedByte, "SCALAR");
    builder.meshes = {
        R"({"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 0}, "indices": 1}]})"};
    builder.nodes.emplace_back(one_triangle().nodes[0]);
    builder.meshes.emplace_back(R"({"primitives": [{"attributes": {"POSITION": 0}}]})");
    builder.nodes[1] = R"({"mesh": 1})";
    const Scene scene = load(builder);
    EXPECT_EQ(scene.surface.triangles.size(), 500'002U);
    EXPECT_TRUE(
        has_warning(scene, "node 'large': is too large to be smoothed further; its 500001"));
}

} // namespace
} // namespace springdrive::scene
