// Covers engine/scene/gltf_accessor.cpp: the bytes of buffers, plain and
// compressed; and damaged files of all kinds, made at random but alike on every run: loading must
// end in a scene or in one line of error, never in a crash. Meant to be run under the sanitizers
// too.
#include "engine/scene/gltf_accessor.h"

#include "tests/engine/scene/gltf_builder.h"

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <meshoptimizer.h>

#include <functional>
#include <random>

namespace springdrive::scene {
namespace {

/// A triangle whose position accessor and buffer view are given in full.
GltfBuilder with_positions(const std::string &accessor, const std::string &view = "") {
    GltfBuilder builder = one_triangle();
    builder.accessors = {accessor};
    if (!view.empty()) {
        builder.views = {view};
    }
    return builder;
}

std::string float_vectors(const std::string &members) {
    return R"({"bufferView": 0, "componentType": 5126, "type": "VEC3", )" + members + "}";
}

TEST(GltfAccessor, InterleavedVerticesAreReadByTheirStride) {
    GltfBuilder builder = one_triangle();
    const std::vector<float> interleaved = {9, 0, 0, 0, 9, 1, 0, 0, 9, 0, 2, 3};
    builder.add_view({reinterpret_cast<const char *>(interleaved.data()), 48},
                     R"(, "byteStride": 16)");
    builder.accessors = {R"({"bufferView": 1, "byteOffset": 4, "componentType": 5126, "count": 3,
                             "type": "VEC3"})"};
    const auto vertices = load(builder).surface.vertices_m;
    EXPECT_EQ(vertices[0], Vector3(0, 0, 0));
    EXPECT_EQ(vertices[1], Vector3(1, 0, 0));
    EXPECT_EQ(vertices[2], Vector3(0, 2, 3));
}

TEST(GltfAccessor, SparseValuesReplaceThoseOfTheView) {
    GltfBuilder builder = one_triangle();
    builder.add_accessor(std::vector<std::uint16_t>{2}, kUnsignedShort, "SCALAR");
    builder.add_accessor(std::vector<float>{0.0F, 0.75F, 0.5F}, kFloat, "VEC3");
    const std::string sparse = R"("sparse": {"count": 1,
        "indices": {"bufferView": 1, "componentType": 5123}, "values": {"bufferView": 2}}})";
    builder.accessors[0] =
        R"({"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", )" + sparse;
    const auto vertices = load(builder).surface.vertices_m;
    EXPECT_EQ(vertices[1], Vector3(0.5, 0, 0));
    EXPECT_EQ(vertices[2], Vector3(0, 0.75, 0.5));

    builder.accessors[0] = R"({"componentType": 5126, "count": 3, "type": "VEC3", )" + sparse;
    const auto from_zero = load(builder).surface.vertices_m;
    EXPECT_EQ(from_zero[1], Vector3(0, 0, 0));
    EXPECT_EQ(from_zero[2], Vector3(0, 0.75, 0.5));
}

TEST(GltfAccessor, RefusesSparsePartsThatReachOutside) {
    struct Case {
        const char *count;
        const char *more_indices;
        const char *values;
        const char *why;
    };
    for (const Case &one : std::vector<Case>{
             {"1", "", "0", "sparse index 3 is beyond its 3 elements"},
             {"4", "", "0", "impossible count"},
             {"-1", "", "0", "accessor 0: sparse: its count is -1"},
             {"2", "", "0", "reach beyond buffer view 1"},
             {"1", R"(, "byteOffset": -2)", "0", "sparse: indices: its byteOffset is -2"},
             {"1", R"(, "componentType": 5126)", "0", "impossible count"},
             {"1", "", "7", "buffer view 7 is not in the file"}}) {
        GltfBuilder builder = one_triangle();
        builder.add_accessor(std::vector<std::uint16_t>{3}, kUnsignedShort, "SCALAR");
        builder.accessors[0] =
            R"({"componentType": 5126, "count": 3, "type": "VEC3", "sparse": {"count": )" +
            std::string(one.count) + R"(, "indices": {"bufferView": 1, "componentType": 5123)" +
            one.more_indices + R"(}, "values": {"bufferView": )" + one.values + "}}}";
        expect_failure(builder, one.why);
    }
}

TEST(GltfAccessor, RefusesWhatReachesOutside) {
    const std::string whole = R"("count": 3, "byteOffset": 0)";
    EXPECT_EQ(load(with_positions(float_vectors(whole))).surface.triangles.size(), 1U);
    for (const auto &[members, why] : std::vector<std::pair<std::string, std::string>>{
             {R"("count": 4, "byteOffset": 0)", "reach beyond buffer view 0 of 36 bytes"},
             {R"("count": 3, "byteOffset": 1)", "reach beyond buffer view 0"},
             {R"("count": 1, "byteOffset": 37)", "reach beyond buffer view 0"},
             {R"("count": 3, "byteOffset": 18446744073709551600)", "reach beyond"},
             // 3 x 12 bytes more than 2^64 would wrap around to 36.
             {R"("count": 1537228672809129305)", "1537228672809129305 vertices"},
             {R"("count": 20000000)", "reach beyond buffer view 0"}}) {
        expect_failure(with_positions(float_vectors(members)), why);
    }
    for (const auto &[view, why] : std::vector<std::pair<std::string, std::string>>{
             {R"("buffer": 0, "byteLength": 37)",
              "buffer view 0: 37 bytes from 0 reach beyond buffer 0 of 36 bytes"},
             {R"("buffer": 0, "byteOffset": 1, "byteLength": 36)", "reach beyond buffer 0"},
             {R"("buffer": 0, "byteLength": 36, "byteOffset": 18446744073709551600)",
              "reach beyond buffer 0"},
             {R"("buffer": 1, "byteLength": 36)", "buffer 1 is not in the file"},
             {R"("buffer": -1, "byteLength": 36)", "buffer -1 is not in the file"},
             {R"("buffer": 0, "byteLength": 36, "byteStride": 8)", "12 bytes, but stand 8 apart"},
             {R"("buffer": 0, "byteLength": 36, "byteStride": 16)",
              "reach beyond buffer view 0"}}) {
        expect_failure(with_positions(float_vectors(whole), "{" + view + "}"), why);
    }
}

TEST(GltfAccessor, RefusesTypesThatAttributesCannotHave) {
    for (const char *type : {"5124", "5125", "5127", "5130"}) {
        expect_failure(with_positions(R"({"bufferView": 0, "type": "VEC3", "count": 3,
                                          "componentType": )" +
                                      std::string(type) + "}"),
                       "accessor 0");
    }
    for (const char *type : {"SCALAR", "MAT2", "MAT4"}) {
        expect_failure(with_positions(R"({"bufferView": 0, "count": 2, "componentType": 5126,
                                          "type": ")" +
                                      std::string(type) + "\"}"),
                       "a vertex attribute is a vector");
    }
}

using Corners = std::array<std::array<float, 3>, 3>;

/// Triangles with all coordinates multiples of 1/64 within [−1, 1].
std::vector<Corners> random_triangles(std::size_t count) {
    std::mt19937_64 random(5);
    std::uniform_int_distribution<int> step(-64, 64);
    std::vector<Corners> triangles(count);
    for (Corners &triangle : triangles) {
        for (auto &corner : triangle) {
            for (float &coordinate : corner) {
                coordinate = static_cast<float>(step(random)) / 64.0F;
            }
        }
    }
    return triangles;
}

/// Draco data, not quantised by default, so that decoding must give back the very numbers.
std::string draco_bytes(const std::vector<Corners> &triangles, int quantisation_bits = 0) {
    draco::TriangleSoupMeshBuilder builder;
    builder.Start(static_cast<int>(triangles.size()));
    const int position =
        builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const auto &[a, b, c] = triangles[i];
        builder.SetAttributeValuesForFace(position, draco::FaceIndex(static_cast<std::uint32_t>(i)),
                                          a.data(), b.data(), c.data());
    }
    const auto mesh = builder.Finalize();
    draco::Encoder encoder;
    if (quantisation_bits > 0) {
        encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, quantisation_bits);
    }
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
    return {buffer.data(), buffer.size()};
}

GltfBuilder compressed(const std::string &bytes, const std::string &attributes) {
    GltfBuilder builder;
    builder.asset = kMetres;
    builder.more = R"("extensionsUsed": ["KHR_draco_mesh_compression"],
                      "extensionsRequired": ["KHR_draco_mesh_compression"], )";
    builder.add_view(bytes);
    builder.accessors = {R"({"componentType": 5126, "count": 3, "type": "VEC3"})",
                         R"({"componentType": 5125, "count": 3, "type": "SCALAR"})"};
    builder.add_mesh(R"("attributes": {"POSITION": 0}, "indices": 1, "extensions":
        {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": )" +
                     attributes + "}}");
    builder.nodes = {R"({"mesh": 0, "name": "packed"})"};
    return builder;
}

std::vector<std::array<double, 9>> sorted(const std::vector<std::array<Vector3, 3>> &triangles) {
    std::vector<std::array<double, 9>> rows;
    for (std::array<Vector3, 3> triangle : triangles) { // from its smallest corner on
        const auto less = [](const Vector3 &a, const Vector3 &b) {
            return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
        };
        std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end(), less),
                    triangle.end());
        std::array<double, 9> row{};
        for (std::size_t i = 0; i < 9; ++i) {
            row[i] = triangle[i / 3][static_cast<int>(i % 3)];
        }
        rows.push_back(row);
    }
    std::sort(rows.begin(), rows.end());
    return rows;
}

TEST(GltfDraco, DecodingGivesBackEveryTriangleWithItsWinding) {
    const std::vector<Corners> triangles = random_triangles(50);
    std::vector<std::array<Vector3, 3>> expected;
    for (const Corners &triangle : triangles) {
        std::array<Vector3, 3> corners;
        for (std::size_t c = 0; c < 3; ++c) {
            corners[c] = Vector3(triangle[c][0], triangle[c][1], triangle[c][2]);
        }
        expected.push_back(corners);
    }
    const GltfBuilder builder = compressed(draco_bytes(triangles), R"({"POSITION": 0})");
    EXPECT_EQ(sorted(corners_of(load_bytes(builder.gltf()).surface)), sorted(expected));
    EXPECT_EQ(sorted(corners_of(load_bytes(builder.glb()).surface)), sorted(expected));
}

TEST(GltfDraco, DamagedDataAreRefused) {
    const std::string good = draco_bytes(random_triangles(20));
    expect_failure(compressed("nonsense", R"({"POSITION": 0})"), "node 'packed'");
    expect_failure(compressed(good, R"({"POSITION": 5})"), "no vectors with the id 5");
    expect_failure(compressed(good, R"({"POSITION": "zero"})"), "the id of POSITION is no integer");
    expect_failure(compressed(good, "7"), "needs bufferView and attributes");
    for (std::size_t size = 1; size < good.size(); size += 7) {
        expect_failure(compressed(good.substr(0, size), R"({"POSITION": 0})"), "Draco");
    }
}

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

TEST(GltfMeshopt, TheKhronosNameIsReadAlikeAndWhatIsNewInItHasAFallback) {
    const auto as_khronos = [](std::string text) {
        for (std::size_t at = 0; (at = text.find("EXT_mesho", at)) != std::string::npos; ++at) {
            text.replace(at, 3, "KHR");
        }
        return text;
    };
    GltfBuilder builder = square(encoded_triangles(), "TRIANGLES");
    EXPECT_EQ(load_bytes(as_khronos(with_fallback_buffer(builder))).surface.triangles.size(), 2U);
    builder.buffer[0] = '\xa1'; // version 1 of the code of attributes
    const std::string refused = failure_of(as_khronos(with_fallback_buffer(builder)));
    EXPECT_NE(refused.find("buffer view 0: KHR_meshopt_compression: is compressed in a way"),
              std::string::npos)
        << refused;
    std::string text = builder.gltf(); // its second buffer has the square uncompressed
    const std::string_view plain(reinterpret_cast<const char *>(kSquare.data()), 48);
    text.insert(text.find("}]", text.find("\"buffers\"")) + 1,
                R"(, {"byteLength": 48, "uri": "data:;base64,)" + to_base64(plain) + "\"}");
    EXPECT_EQ(load_bytes(as_khronos(text)).surface.vertices_m[3], Vector3(0.5, 0.25, 0));
}

/// Ends in a scene whose indices are sound, or in an InputError of one line.
void expect_survived(const std::filesystem::path &file) {
    try {
        const Scene scene = load_gltf(file, small_workspace());
        EXPECT_FALSE(scene.surface.triangles.empty());
        for (const auto &triangle : scene.surface.triangles) {
            for (const std::uint32_t index : triangle) {
                ASSERT_LT(index, scene.surface.vertices_m.size());
                ASSERT_TRUE(scene.surface.vertices_m[index].allFinite());
            }
        }
        for (const VisualMesh &mesh : scene.meshes) {
            for (const std::uint32_t index : mesh.indices) {
                ASSERT_LT(index, mesh.vertices.size());
            }
            ASSERT_LT(mesh.texture, static_cast<int>(scene.textures.size()));
        }
    } catch (const InputError &error) {
        ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
}

/// A file with something of everything: strips, sparse data, colours, nodes, extras, an image, a
/// skin, morph targets, instances.
GltfBuilder full_builder() {
    GltfBuilder builder = one_triangle(R"("name": "a", "extras": {"eta": 0.5})");
    builder.add_accessor(std::vector<std::uint16_t>{0, 1, 2, 1}, kUnsignedShort, "SCALAR");
    builder.add_accessor(std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 1}, kFloat, "VEC3");
    builder.add_accessor(std::vector<float>{0, 0, 1, 0, 0, 1}, kFloat, "VEC2");
    builder.add_accessor(std::vector<std::uint8_t>(12, 200), kUnsignedByte, "VEC4");
    builder.accessors.emplace_back(
        R"({"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "sparse":
            {"count": 1, "indices": {"bufferView": 1, "componentType": 5123},
             "values": {"bufferView": 2}}})");
    const int image = builder.add_view("\x89PNG\r\n\x1a\n and nothing more");
    builder.images = {R"({"mimeType": "image/png", "bufferView": )" + std::to_string(image) + "}"};
    builder.textures = {R"({"source": 0})"};
    builder.materials = {R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}})"};
    builder.add_accessor(std::vector<std::uint8_t>{0, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0},
                         kUnsignedByte, "VEC4"); // 6
    builder.add_accessor(std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 0.5, 0.5, 0, 0}, kFloat,
                         "VEC4");
    builder.add_accessor(std::vector<float>(32, 0.25F), kFloat, "MAT4");
    builder.meshes.emplace_back(R"({"primitives": [{"mode": 5, "indices": 1, "material": 0,
        "targets": [{"POSITION": 5, "NORMAL": 2}, {"POSITION": 0}], "attributes": {"POSITION": 5,
        "NORMAL": 2, "TEXCOORD_0": 3, "COLOR_0": 4, "JOINTS_0": 6, "WEIGHTS_0": 7}}],
        "weights": [0.5, 0]})");
    builder.nodes.emplace_back(R"({"children": [2, 3], "rotation": [0, 0, 0.6, 0.8]})");
    builder.nodes.emplace_back(R"({"mesh": 1, "scale": [1, -1, 1]})");
    builder.nodes.emplace_back(R"({"mesh": 1, "skin": 0, "weights": [1, 1], "children": [4]})");
    builder.nodes.emplace_back(R"({"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing":
        {"attributes": {"TRANSLATION": 0, "SCALE": 2}}}})");
    builder.more = R"("skins": [{"joints": [1, 2], "inverseBindMatrices": 8}], )";
    builder.scenes = {R"({"nodes": [0, 1]})"};
    return builder;
}

/// A compressed ribbon of 20 triangles.
GltfBuilder draco_builder() {
    std::vector<Corners> ribbon(20);
    for (std::size_t i = 0; i < ribbon.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto x = static_cast<float>(i + k);
            ribbon[i][k] = {x, (i + k) % 2 == 0 ? 0.0F : 1.0F, 0.1F * x * x};
        }
    }
    return compressed(draco_bytes(ribbon, 11), R"({"POSITION": 0})");
}

void truncate_everywhere(const std::string &bytes) {
    const TemporaryFolder folder;
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        expect_survived(folder.write("cut.gltf", std::string_view(bytes).substr(0, size)));
    }
}

constexpr int kDamagedFiles = 1500;

/// @param file_of  the file with these bytes, if they are only a part of it
void flip_bytes(const std::string &bytes, std::uint64_t seed,
                const std::function<std::string(const std::string &)> &file_of = nullptr) {
    const TemporaryFolder folder;
    std::mt19937_64 random(seed);
    for (int i = 0; i < kDamagedFiles; ++i) {
        std::string damaged = bytes;
        for (std::uint64_t flips = 1 + random() % 3; flips > 0; --flips) {
            damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
        }
        expect_survived(folder.write("flipped.gltf", file_of ? file_of(damaged) : damaged));
    }
}

TEST(GltfHostile, TruncatedFiles) {
    truncate_everywhere(full_builder().glb());
    truncate_everywhere(full_builder().gltf());
}

TEST(GltfHostile, FlippedBytes) {
    flip_bytes(full_builder().glb(), 1);
    flip_bytes(full_builder().gltf(), 2);
}

/// Replaces one number of the JSON by another that fits or does not.
TEST(GltfHostile, ChangedNumbers) {
    const std::string text = full_builder().gltf();
    const std::array<std::string, 12> values = {"0",    "1",          "2",          "-1",
                                                "255",  "2147483648", "1e300",      "0.5",
                                                "null", "\"x\"",      "4294967295", "1e-300"};
    const TemporaryFolder folder;
    std::mt19937_64 random(3);
    for (int i = 0; i < kDamagedFiles; ++i) {
        std::string damaged = text;
        const std::size_t from = random() % damaged.size();
        const std::size_t digit = damaged.find_first_of("0123456789", from);
        if (digit == std::string::npos || damaged.rfind("base64", digit) != std::string::npos) {
            continue;
        }
        const std::size_t end = damaged.find_first_not_of("0123456789", digit);
        damaged.replace(digit, end - digit, values[random() % values.size()]);
        expect_survived(folder.write("changed.gltf", damaged));
    }
}

TEST(GltfHostile, DamagedDracoData) {
    flip_bytes(draco_builder().glb(), 4);
    truncate_everywhere(draco_builder().glb());
}

TEST(GltfHostile, DamagedMeshoptData) {
    const GltfBuilder builder = square(encoded_triangles(), "TRIANGLES");
    flip_bytes(builder.buffer, 11, [&builder](const std::string &damaged) {
        GltfBuilder other = builder;
        other.buffer = damaged;
        return with_fallback_buffer(other);
    });
}

TEST(GltfHostile, TheUndamagedFilesLoad) {
    EXPECT_EQ(load(full_builder()).surface.triangles.size(), 8U);
    EXPECT_EQ(load_bytes(draco_builder().glb()).surface.triangles.size(), 20U);
}

} // namespace
} // namespace springdrive::scene
