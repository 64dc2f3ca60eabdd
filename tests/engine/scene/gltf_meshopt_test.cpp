#include "engine/scene/gltf_meshopt.h"

#include "tests/engine/scene/gltf_builder.h"

#include <meshoptimizer.h>

#include <random>

namespace springdrive::scene {
namespace {

/// A square in 4 vertices and 2 triangles.
const std::vector<float> kSquare = {0, 0, 0, 0.5F, 0, 0, 0, 0.25F, 0, 0.5F, 0.25F, 0};
const std::vector<unsigned> kCorners = {0, 1, 2, 2, 1, 3};

std::string encoded_vertices(const void *vertices, std::size_t count, std::size_t stride_bytes) {
    std::string bytes(meshopt_encodeVertexBufferBound(count, stride_bytes), '\0');
    bytes.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char *>(bytes.data()),
                                            bytes.size(), vertices, count, stride_bytes));
    return bytes;
}

std::string encoded_triangles() {
    std::string bytes(meshopt_encodeIndexBufferBound(kCorners.size(), 4), '\0');
    bytes.resize(meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char *>(bytes.data()),
                                           bytes.size(), kCorners.data(), kCorners.size()));
    return bytes;
}

std::string encoded_sequence() {
    std::string bytes(meshopt_encodeIndexSequenceBound(kCorners.size(), 4), '\0');
    bytes.resize(meshopt_encodeIndexSequence(reinterpret_cast<unsigned char *>(bytes.data()),
                                             bytes.size(), kCorners.data(), kCorners.size()));
    return bytes;
}

/// A view whose uncompressed bytes would be in a buffer without any, as `gltfpack` writes it.
int add_compressed(GltfBuilder &builder, const std::string &bytes, std::size_t count,
                   std::size_t stride_bytes, const std::string &mode,
                   const std::string &filter = "NONE") {
    const int view = builder.add_view(bytes);
    const std::string place = builder.views.back();
    const auto length = std::to_string(count * stride_bytes);
    builder.views.back() = R"({"buffer": 1, "byteLength": )" + length +
                           R"(, "extensions": {"EXT_meshopt_compression": )" +
                           place.substr(0, place.size() - 1) + R"(, "count": )" +
                           std::to_string(count) + R"(, "byteStride": )" +
                           std::to_string(stride_bytes) + R"(, "mode": ")" + mode +
                           R"(", "filter": ")" + filter + "\"}}}";
    return view;
}

std::string with_fallback_buffer(const GltfBuilder &builder) {
    std::string text = builder.gltf();
    text.insert(text.find("}]", text.find("\"buffers\"")) + 1,
                R"(, {"byteLength": 1000, "extensions": {"EXT_meshopt_compression":
                    {"fallback": true}}})");
    return text;
}

std::string accessor(int view, int component_type, std::size_t count, const std::string &type) {
    return R"({"bufferView": )" + std::to_string(view) + R"(, "componentType": )" +
           std::to_string(component_type) + R"(, "count": )" + std::to_string(count) +
           R"(, "type": ")" + type + "\"}";
}

GltfBuilder empty_builder() {
    GltfBuilder builder;
    builder.asset = kMetres;
    builder.more = R"("extensionsRequired": ["EXT_meshopt_compression"], )";
    builder.nodes = {R"({"mesh": 0})"};
    return builder;
}

/// The square, compressed; its corners as `corner_bytes`.
GltfBuilder square(const std::string &corner_bytes, const std::string &corner_mode) {
    GltfBuilder builder = empty_builder();
    add_compressed(builder, encoded_vertices(kSquare.data(), 4, 12), 4, 12, "ATTRIBUTES");
    add_compressed(builder, corner_bytes, kCorners.size(), 2, corner_mode);
    builder.accessors = {accessor(0, kFloat, 4, "VEC3"),
                         accessor(1, kUnsignedShort, kCorners.size(), "SCALAR")};
    builder.add_mesh(R"("attributes": {"POSITION": 0}, "indices": 1)");
    return builder;
}

TEST(GltfMeshopt, TrianglesAndSequencesAreDecoded) {
    for (const GltfBuilder &builder :
         {square(encoded_triangles(), "TRIANGLES"), square(encoded_sequence(), "INDICES")}) {
        const auto corners = corners_of(load_bytes(with_fallback_buffer(builder)).surface);
        ASSERT_EQ(corners.size(), 2U);
        EXPECT_EQ(corners[0][0] + corners[0][1] + corners[0][2], Vector3(0.5, 0.25, 0));
        EXPECT_EQ(corners[1][0] + corners[1][1] + corners[1][2], Vector3(1, 0.5, 0));
    }
}

TEST(GltfMeshopt, TheExponentialFilterGivesPositions) {
    std::vector<unsigned> filtered(kSquare.size());
    meshopt_encodeFilterExp(filtered.data(), 4, 12, 15, kSquare.data());
    GltfBuilder builder = empty_builder();
    add_compressed(builder, encoded_vertices(filtered.data(), 4, 12), 4, 12, "ATTRIBUTES",
                   "EXPONENTIAL");
    builder.accessors = {accessor(0, kFloat, 4, "VEC3")};
    builder.add_mesh(R"("attributes": {"POSITION": 0}, "mode": 5)");
    const Scene scene = load_bytes(with_fallback_buffer(builder));
    ASSERT_EQ(scene.surface.vertices_m.size(), 4U);
    EXPECT_EQ(scene.surface.vertices_m[3], Vector3(0.5, 0.25, 0)); // exact in 15 bits
}

TEST(GltfMeshopt, TheOctahedralFilterGivesNormals) {
    const std::vector<float> normals = {0, 0.6F, 0.8F, 0, 0, 0, 1, 0, 0, -1, 0, 0};
    std::vector<std::int8_t> filtered(normals.size());
    meshopt_encodeFilterOct(filtered.data(), 3, 4, 8, normals.data());
    GltfBuilder builder = one_triangle();
    add_compressed(builder, encoded_vertices(filtered.data(), 3, 4), 3, 4, "ATTRIBUTES",
                   "OCTAHEDRAL");
    builder.accessors.emplace_back(R"({"bufferView": 1, "componentType": 5120, "normalized": true,
                                    "count": 3, "type": "VEC3"})");
    builder.views[1].replace(builder.views[1].find(R"("byteLength": 12)"), 16,
                             R"("byteLength": 12, "byteStride": 4)");
    builder.meshes = {R"({"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}}]})"};
    const VisualMesh mesh = load_bytes(with_fallback_buffer(builder)).meshes.front();
    ASSERT_EQ(mesh.vertices.size(), 3U);
    constexpr float kQuantum = 0.02F; // of 8 bits
    EXPECT_NEAR(mesh.vertices[0].normal[1], 0.6F, kQuantum);
    EXPECT_NEAR(mesh.vertices[0].normal[2], 0.8F, kQuantum);
    EXPECT_NEAR(mesh.vertices[1].normal[2], 1.0F, kQuantum);
    EXPECT_NEAR(mesh.vertices[2].normal[1], -1.0F, kQuantum);
}

TEST(GltfMeshopt, WhatCannotBeIsRefusedByName) {
    struct Case {
        const char *from;
        const char *to;
        std::string line;
    };
    const std::string place = "buffer view 0: EXT_meshopt_compression: ";
    for (const Case &one : std::vector<Case>{
             {R"("count": 4, "byteS)", R"("count": -4, "byteS)",
              place + "its count must be a whole number from 0"},
             {R"("count": 4, "byteS)", R"("count": 70000000, "byteS)",
              place + "holds 70000000 elements; at most 60000000 are allowed"},
             {R"("count": 4, "byteS)", R"("count": 400, "byteS)",
              place + "its compressed data are damaged; export it again"},
             {"\"byteStride\": 12", "\"byteStride\": 10",
              place + "mode 'ATTRIBUTES' with filter 'NONE' does not exist for 4 elements of 10 "
                      "bytes"},
             {"\"ATTRIBUTES\"", "\"TRIANGLES\"",
              place + "mode 'TRIANGLES' with filter 'NONE' does not exist for 4 elements of 12 "
                      "bytes"},
             {"\"NONE\"", "\"QUATERNION\"",
              place + "mode 'ATTRIBUTES' with filter 'QUATERNION' does not exist for 4 elements of "
                      "12 bytes"},
             {"\"buffer\": 0", "\"buffer\": 7", place + "buffer 7 is not in the file"}}) {
        std::string text = with_fallback_buffer(square(encoded_triangles(), "TRIANGLES"));
        text.replace(text.find(one.from), std::string_view(one.from).size(), one.to);
        EXPECT_EQ(line_of_failure(text), one.line);
    }
}

TEST(GltfMeshopt, DamagedDataEndInASceneOrInOneLine) {
    const GltfBuilder builder = square(encoded_triangles(), "TRIANGLES");
    std::mt19937_64 random(11);
    for (int trial = 0; trial < 1000; ++trial) {
        GltfBuilder damaged = builder;
        for (std::uint64_t flips = 1 + random() % 3; flips > 0; --flips) {
            damaged.buffer[random() % damaged.buffer.size()] = static_cast<char>(random() % 256);
        }
        try {
            for (const Vector3 &vertex_m :
                 load_bytes(with_fallback_buffer(damaged)).surface.vertices_m) {
                ASSERT_TRUE(vertex_m.allFinite());
            }
        } catch (const InputError &error) {
            ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        }
    }
}

} // namespace
} // namespace springdrive::scene
