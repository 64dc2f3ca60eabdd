// Damaged files, made at random but alike on every run: loading must end in a scene or in one
// line of error, never in a crash. Meant to be run under the sanitizers too.
#include "engine/scene/gltf.h"

#include "tests/engine/scene/gltf_builder.h"

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>

#include <random>

namespace springdrive::scene {
namespace {

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

/// A file with something of everything: strips, sparse data, colours, nodes, extras, an image.
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
    builder.meshes.emplace_back(R"({"primitives": [{"mode": 5, "indices": 1, "material": 0,
        "attributes": {"POSITION": 5, "NORMAL": 2, "TEXCOORD_0": 3, "COLOR_0": 4}}]})");
    builder.nodes.emplace_back(R"({"children": [2], "rotation": [0, 0, 0.6, 0.8]})");
    builder.nodes.emplace_back(R"({"mesh": 1, "scale": [1, -1, 1]})");
    builder.scenes = {R"({"nodes": [0, 1]})"};
    return builder;
}

/// A Draco-compressed ribbon of 20 triangles.
GltfBuilder draco_builder() {
    draco::TriangleSoupMeshBuilder mesh_builder;
    mesh_builder.Start(20);
    const int position =
        mesh_builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    for (std::uint32_t i = 0; i < 20; ++i) {
        const auto corner = [&](std::uint32_t k) {
            const auto x = static_cast<float>(k);
            return std::array<float, 3>{x, k % 2 == 0 ? 0.0F : 1.0F, 0.1F * x * x};
        };
        mesh_builder.SetAttributeValuesForFace(position, draco::FaceIndex(i), corner(i).data(),
                                               corner(i + 1).data(), corner(i + 2).data());
    }
    draco::Encoder encoder;
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 11);
    draco::EncoderBuffer bytes;
    EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh_builder.Finalize(), &bytes).ok());
    GltfBuilder builder;
    builder.more = R"("extensionsUsed": ["KHR_draco_mesh_compression"], )";
    builder.add_view({bytes.data(), bytes.size()});
    builder.accessors = {R"({"componentType": 5126, "count": 22, "type": "VEC3"})"};
    builder.add_mesh(R"("attributes": {"POSITION": 0}, "extensions":
        {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}})");
    builder.nodes = {R"({"mesh": 0})"};
    return builder;
}

void truncate_everywhere(const std::string &bytes) {
    const TemporaryFolder folder;
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        expect_survived(folder.write("cut.gltf", std::string_view(bytes).substr(0, size)));
    }
}

void flip_bytes(const std::string &bytes, std::uint64_t seed, int trials) {
    const TemporaryFolder folder;
    std::mt19937_64 random(seed);
    for (int trial = 0; trial < trials; ++trial) {
        std::string damaged = bytes;
        for (std::uint64_t flips = 1 + random() % 3; flips > 0; --flips) {
            damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
        }
        expect_survived(folder.write("flipped.gltf", damaged));
    }
}

/// Replaces one number of the JSON by another that fits or does not.
void change_numbers(const std::string &text, std::uint64_t seed, int trials) {
    const std::array<std::string, 12> values = {"0",    "1",          "2",          "-1",
                                                "255",  "2147483648", "1e300",      "0.5",
                                                "null", "\"x\"",      "4294967295", "1e-300"};
    const TemporaryFolder folder;
    std::mt19937_64 random(seed);
    for (int trial = 0; trial < trials; ++trial) {
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

constexpr int kTrials = 1500;

TEST(GltfHostile, TruncatedFiles) {
    truncate_everywhere(full_builder().glb());
    truncate_everywhere(full_builder().gltf());
}

TEST(GltfHostile, FlippedBytes) {
    flip_bytes(full_builder().glb(), 1, kTrials);
    flip_bytes(full_builder().gltf(), 2, kTrials);
}

TEST(GltfHostile, ChangedNumbers) { change_numbers(full_builder().gltf(), 3, kTrials); }

TEST(GltfHostile, DamagedDracoData) {
    flip_bytes(draco_builder().glb(), 4, kTrials);
    truncate_everywhere(draco_builder().glb());
}

TEST(GltfHostile, TheUndamagedFilesLoad) {
    EXPECT_EQ(load(full_builder()).surface.triangles.size(), 3U);
    EXPECT_EQ(load_bytes(draco_builder().glb()).surface.triangles.size(), 20U);
}

} // namespace
} // namespace springdrive::scene
