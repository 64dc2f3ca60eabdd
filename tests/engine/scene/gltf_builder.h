// Tiny glTF files, made in the tests themselves, and what loading them gives.
#pragma once

#include "base/input_error.h"
#include "engine/scene/gltf.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::scene {

inline constexpr int kByte = 5120;
inline constexpr int kUnsignedByte = 5121;
inline constexpr int kShort = 5122;
inline constexpr int kUnsignedShort = 5123;
inline constexpr int kUnsignedInt = 5125;
inline constexpr int kFloat = 5126;

inline device::Workspace small_workspace() {
    return {Vector3(0.0, 0.03, -0.015), Vector3(0.2, 0.1, 0.1)};
}

inline std::string to_base64(std::string_view bytes) {
    constexpr std::string_view kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t there = std::min<std::size_t>(3, bytes.size() - i);
        std::uint32_t group = 0;
        for (std::size_t b = 0; b < 3; ++b) {
            group = group * 256 + (b < there ? static_cast<unsigned char>(bytes[i + b]) : 0U);
        }
        for (std::size_t d = 0; d < 4; ++d) {
            text += d <= there ? kDigits[group >> (18 - 6 * d) & 63U] : '=';
        }
    }
    return text;
}

inline std::string percent_encoded(std::string_view bytes) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    std::string text;
    for (const char c : bytes) {
        const auto byte = static_cast<unsigned char>(c);
        text += {'%', kDigits[byte / 16], kDigits[byte % 16]};
    }
    return text;
}

inline std::string uint32_bytes(std::size_t value) {
    const auto narrow = static_cast<std::uint32_t>(value);
    std::string bytes(sizeof narrow, '\0');
    std::memcpy(bytes.data(), &narrow, sizeof narrow);
    return bytes;
}

/// Collects the pieces of a glTF file. All pieces are JSON text, so that a test can say anything,
/// also what is wrong.
class GltfBuilder {
public:
    std::string asset = R"({"version": "2.0"})";
    std::vector<std::string> meshes, nodes, scenes, materials, textures, images, samplers;
    std::vector<std::string> accessors, views;
    std::string more;   ///< further members of the root: `"scene": 1, `
    std::string buffer; ///< the bytes

    int add_view(std::string_view bytes, const std::string &extra = "") {
        buffer.resize((buffer.size() + 3) / 4 * 4);
        views.push_back(R"({"buffer": 0, "byteOffset": )" + std::to_string(buffer.size()) +
                        R"(, "byteLength": )" + std::to_string(bytes.size()) + extra + "}");
        buffer += bytes;
        return static_cast<int>(views.size()) - 1;
    }

    template <typename Number>
    int add_accessor(const std::vector<Number> &numbers, int component_type,
                     const std::string &type, const std::string &extra = "") {
        const std::size_t width = type == "SCALAR" ? 1
                                  : type == "MAT4" ? 16
                                                   : static_cast<std::size_t>(type[3] - '0');
        const std::string_view bytes(reinterpret_cast<const char *>(numbers.data()),
                                     numbers.size() * sizeof(Number));
        const int view = add_view(bytes);
        accessors.push_back(R"({"bufferView": )" + std::to_string(view) + R"(, "componentType": )" +
                            std::to_string(component_type) + R"(, "count": )" +
                            std::to_string(numbers.size() / width) + R"(, "type": ")" + type +
                            "\"" + extra + "}");
        return static_cast<int>(accessors.size()) - 1;
    }

    int add_positions(const std::vector<float> &numbers) {
        return add_accessor(numbers, kFloat, "VEC3");
    }

    /// @param primitive what stands between its braces
    int add_mesh(const std::string &primitive) {
        meshes.push_back(R"({"primitives": [{)" + primitive + "}]}");
        return static_cast<int>(meshes.size()) - 1;
    }

    [[nodiscard]] std::string json(const std::string &uri = "") const {
        const auto list = [](const std::string &name, const std::vector<std::string> &items) {
            std::string text;
            for (const std::string &item : items) {
                text += (text.empty() ? "" : ", ") + item;
            }
            return items.empty() ? "" : "\"" + name + "\": [" + text + "], ";
        };
        std::string text =
            "{" + more + list("meshes", meshes) + list("nodes", nodes) + list("scenes", scenes) +
            list("materials", materials) + list("textures", textures) + list("images", images) +
            list("samplers", samplers) + list("accessors", accessors) + list("bufferViews", views);
        if (!buffer.empty()) {
            text += R"("buffers": [{"byteLength": )" + std::to_string(buffer.size()) +
                    (uri.empty() ? "" : R"(, "uri": ")" + uri + "\"") + "}], ";
        }
        return text + R"("asset": )" + asset + "}";
    }

    [[nodiscard]] std::string gltf() const {
        return json("data:application/octet-stream;base64," + to_base64(buffer));
    }

    [[nodiscard]] std::string glb() const {
        std::string text = json();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        std::string bytes = buffer;
        bytes.resize((bytes.size() + 3) / 4 * 4);
        std::string chunks = uint32_bytes(text.size()) + "JSON" + text;
        if (!bytes.empty()) {
            chunks += uint32_bytes(bytes.size()) + std::string("BIN\0", 4) + bytes;
        }
        return "glTF" + uint32_bytes(2) + uint32_bytes(12 + chunks.size()) + chunks;
    }
};

/// A folder of a test's own, gone after it.
class TemporaryFolder {
public:
    TemporaryFolder() {
        std::string pattern =
            (std::filesystem::temp_directory_path() / "springdrive-XXXXXX").string();
        path_ = ::mkdtemp(pattern.data());
    }
    ~TemporaryFolder() { std::filesystem::remove_all(path_); }
    TemporaryFolder(const TemporaryFolder &) = delete;
    TemporaryFolder &operator=(const TemporaryFolder &) = delete;

    std::filesystem::path write( // NOLINT(modernize-use-nodiscard)
        const std::string &name, std::string_view bytes) const {
        const std::filesystem::path file = path_ / name;
        std::filesystem::remove(file); // some file systems are slow to overwrite
        std::ofstream stream(file, std::ios::binary);
        stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        return file;
    }
    [[nodiscard]] const std::filesystem::path &path() const { return path_; }

private:
    std::filesystem::path path_;
};

inline Scene load_bytes(std::string_view bytes) {
    const TemporaryFolder folder;
    return load_gltf(folder.write("scene.gltf", bytes), small_workspace());
}

inline Scene load(const GltfBuilder &builder) { return load_bytes(builder.gltf()); }

/// The message with which loading fails; it is one line and names the file.
inline std::string failure_of(std::string_view bytes) {
    const std::string message = error_text_of([&] { static_cast<void>(load_bytes(bytes)); });
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_NE(message.find("scene.gltf: "), std::string::npos)
        << "loaded, or without it: " << message;
    EXPECT_LT(message.size(), 700U) << message;
    return message;
}

/// The same without the file's name.
inline std::string line_of_failure(std::string_view bytes) {
    const std::string message = failure_of(bytes);
    const std::string_view file = "scene.gltf: ";
    return message.substr(std::min(message.size(), message.find(file) + file.size()));
}

inline std::string failure_of(const GltfBuilder &builder) { return failure_of(builder.gltf()); }

inline void expect_failure(const GltfBuilder &builder, const std::string &part) {
    const std::string message = failure_of(builder);
    EXPECT_NE(message.find(part), std::string::npos) << message;
}

inline bool has_warning(const Scene &scene, const std::string &part) {
    for (const std::string &warning : scene.warnings) {
        if (warning.find(part) != std::string::npos) {
            return true;
        }
    }
    return false;
}

/// In metres, so that coordinates come through as they are.
inline const std::string kMetres = R"({"version": "2.0", "extras": {"units": "m"}})";

inline const std::vector<float> kTriangle = {0.0F, 0.0F, 0.0F, 0.5F, 0.0F, 0.0F, 0.0F, 0.25F, 0.0F};

/// One right-angled triangle, (0,0,0) (½,0,0) (0,¼,0), in metres, in one node.
inline GltfBuilder one_triangle(const std::string &node_members = "") {
    GltfBuilder builder;
    builder.asset = kMetres;
    const int position = builder.add_positions(kTriangle);
    builder.add_mesh(R"("attributes": {"POSITION": )" + std::to_string(position) + "}");
    builder.nodes = {R"({"mesh": 0)" + (node_members.empty() ? "" : ", " + node_members) + "}"};
    return builder;
}

/// The corners of every triangle, in order.
inline std::vector<std::array<Vector3, 3>> corners_of(const contact::TriangleSoup &surface) {
    std::vector<std::array<Vector3, 3>> corners;
    for (const auto &triangle : surface.triangles) {
        corners.push_back({surface.vertices_m[triangle[0]], surface.vertices_m[triangle[1]],
                           surface.vertices_m[triangle[2]]});
    }
    return corners;
}

/// What the triangles enclose, in cubic units; negative where they are wound inwards.
inline double volume_of(const contact::TriangleSoup &surface) {
    double six_volumes = 0.0;
    for (const auto &[a, b, c] : corners_of(surface)) {
        six_volumes += a.dot(b.cross(c));
    }
    return six_volumes / 6.0;
}

} // namespace springdrive::scene
