#include "engine/scene/gltf_draco.h"

#include "tests/engine/scene/gltf_builder.h"

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>

#include <random>

namespace springdrive::scene {
namespace {

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
