#include "engine/scene/gltf_accessor.h"

#include "tests/engine/scene/gltf_builder.h"

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>

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
    const auto failing = [](const std::string &sparse, const std::string &message) {
        GltfBuilder builder = one_triangle();
        builder.add_accessor(std::vector<std::uint16_t>{3}, kUnsignedShort, "SCALAR");
        builder.accessors[0] = R"({"componentType": 5126, "count": 3, "type": "VEC3",
            "sparse": )" + sparse +
                               "}";
        expect_failure(builder, message);
    };
    const auto sparse = [](const std::string &count, const std::string &indices,
                           const std::string &values) {
        return R"({"count": )" + count + R"(, "indices": {)" + indices + R"(}, "values": {)" +
               values + "}}";
    };
    const std::string indices = R"("bufferView": 1, "componentType": 5123)";
    const std::string values = R"("bufferView": 0)";
    failing(sparse("1", indices, values), "sparse index 3 is beyond its 3 elements");
    failing(sparse("4", indices, values), "impossible count");
    failing(sparse("-1", indices, values), "accessor 0: sparse: its count is -1");
    failing(sparse("2", indices, values), "reach beyond buffer view 1");
    failing(sparse("1", indices + R"(, "byteOffset": -2)", values),
            "accessor 0: sparse: indices: its byteOffset is -2");
    failing(sparse("1", R"("bufferView": 1, "componentType": 5126)", values), "impossible count");
    failing(sparse("1", indices, R"("bufferView": 7)"), "buffer view 7 is not in the file");
}

TEST(GltfAccessor, RefusesWhatReachesOutsideItsView) {
    const auto accessor = [](const std::string &count, const std::string &offset) {
        return R"({"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": )" + count +
               R"(, "byteOffset": )" + offset + "}";
    };
    EXPECT_EQ(load(with_positions(accessor("3", "0"))).surface.triangles.size(), 1U);
    expect_failure(with_positions(accessor("4", "0")), "reach beyond buffer view 0 of 36 bytes");
    expect_failure(with_positions(accessor("3", "1")), "reach beyond buffer view 0");
    expect_failure(with_positions(accessor("1", "37")), "reach beyond buffer view 0");
    expect_failure(with_positions(accessor("3", "18446744073709551600")), "reach beyond");
    // 3 × 12 bytes more than 2⁶⁴ would wrap around to 36.
    expect_failure(with_positions(accessor("1537228672809129305", "0")),
                   "1537228672809129305 vertices");
    expect_failure(with_positions(accessor("20000000", "0")), "reach beyond buffer view 0");
}

TEST(GltfAccessor, RefusesViewsThatReachOutsideTheirBuffer) {
    const std::string accessor =
        R"({"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3})";
    const auto view = [](const std::string &members) { return "{" + members + "}"; };
    expect_failure(with_positions(accessor, view(R"("buffer": 0, "byteLength": 37)")),
                   "buffer view 0: 37 bytes from 0 reach beyond buffer 0 of 36 bytes");
    expect_failure(with_positions(accessor, view(R"("buffer": 0, "byteOffset": 1,
                                                    "byteLength": 36)")),
                   "reach beyond buffer 0");
    expect_failure(with_positions(accessor, view(R"("buffer": 0, "byteLength": 36,
                                                    "byteOffset": 18446744073709551600)")),
                   "reach beyond buffer 0");
    expect_failure(with_positions(accessor, view(R"("buffer": 1, "byteLength": 36)")),
                   "buffer 1 is not in the file");
    expect_failure(with_positions(accessor, view(R"("buffer": -1, "byteLength": 36)")),
                   "buffer -1 is not in the file");
    expect_failure(with_positions(accessor, view(R"("buffer": 0, "byteLength": 36,
                                                    "byteStride": 8)")),
                   "take 12 bytes, but stand 8 apart");
    expect_failure(with_positions(accessor, view(R"("buffer": 0, "byteLength": 36,
                                                    "byteStride": 16)")),
                   "reach beyond buffer view 0");
}

TEST(GltfAccessor, RefusesComponentTypesThatAttributesCannotHave) {
    for (const char *type : {"5124", "5125", "5127", "5130"}) {
        const std::string message = failure_of(
            with_positions(R"({"bufferView": 0, "type": "VEC3", "count": 3, "componentType": )" +
                           std::string(type) + "}"));
        EXPECT_NE(message.find("accessor 0"), std::string::npos) << message;
    }
    expect_failure(with_positions(R"({"bufferView": 0, "type": "SCALAR", "count": 3,
                                      "componentType": 5126})"),
                   "a vertex attribute is a vector");
    expect_failure(with_positions(R"({"bufferView": 0, "type": "MAT2", "count": 2,
                                      "componentType": 5126})"),
                   "a vertex attribute is a vector");
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

/// Unquantised Draco data, so that decoding must give back the very numbers.
std::string draco_bytes(const std::vector<Corners> &triangles) {
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

} // namespace
} // namespace springdrive::scene
