#include "assets/scenes/gltf_writer.h"

#include <charconv>
#include <cstring>
#include <string_view>

namespace springdrive::scenes {

namespace {

constexpr int kFloat = 5126;
constexpr int kUnsignedByte = 5121;
constexpr int kUnsignedShort = 5123;
constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;

std::string base64(std::string_view bytes) {
    constexpr std::string_view kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t group = 0;
        for (std::size_t b = 0; b < 3; ++b) {
            const bool there = i + b < bytes.size();
            group = group << 8U | (there ? static_cast<unsigned char>(bytes[i + b]) : 0U);
        }
        for (std::size_t d = 0; d < 4; ++d) {
            const bool there = i + d <= bytes.size(); // n bytes need n + 1 digits
            text += there ? kDigits[group >> (18U - 6U * d) & 63U] : '=';
        }
    }
    return text;
}

template <typename Number> std::string number(Number value) {
    std::array<char, 32> text{};
    const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
    return {text.data(), end};
}

template <typename Value> void append(std::string &bytes, const Value &value) {
    std::array<char, sizeof value> raw{};
    std::memcpy(raw.data(), &value, sizeof value); // glTF and all our machines: little-endian
    bytes.append(raw.data(), raw.size());
}

/// Objects of a JSON array, one per line.
struct JsonList {
    std::string text;
    int count = 0;

    int add(const std::string &object) {
        text += (count == 0 ? "\n    " : ",\n    ") + object;
        return count++;
    }
    [[nodiscard]] std::string member(const std::string &name) const {
        return "  \"" + name + "\": [" + text + "\n  ],\n";
    }
};

class Writer {
public:
    std::string write(const SceneDescription &scene) {
        for (const Part &part : scene.parts) {
            add_part(part);
        }
        std::string root_nodes;
        for (int node = 0; node < nodes_.count; ++node) {
            root_nodes += (node == 0 ? "" : ", ") + number(node);
        }
        return "{\n"
               R"(  "asset": {"version": "2.0", "generator": "springdrive generate_scenes"},)"
               "\n  \"scene\": 0,\n"
               R"(  "scenes": [{"name": ")" +
               scene.name + R"(", "nodes": [)" + root_nodes + "], " + extras_of(scene) + "}],\n" +
               nodes_.member("nodes") + meshes_.member("meshes") + materials_.member("materials") +
               accessors_.member("accessors") + views_.member("bufferViews") +
               R"(  "buffers": [{"byteLength": )" + number(bytes_.size()) +
               R"(, "uri": "data:application/octet-stream;base64,)" + base64(bytes_) + "\"}]\n}\n";
    }

private:
    static std::string list_of(const Vector3 &v) {
        return "[" + number(v.x()) + ", " + number(v.y()) + ", " + number(v.z()) + "]";
    }

    static std::string lesson_of(const Lesson &lesson) {
        return R"("lesson": {"title": ")" + lesson.title + R"(", "feel": ")" + lesson.feel + '"' +
               (lesson.spot ? R"(, "point": )" + list_of(lesson.spot->point_m) + R"(, "normal": )" +
                                  list_of(lesson.spot->normal)
                            : "") +
               "}";
    }

    static std::string extras_of(const SceneDescription &scene) {
        const Tolerance &tolerance = scene.tolerance;
        return R"("extras": {)" + lesson_of(scene.lesson) + ", " +
               std::string(scene.in_metres ? R"("units": "m", )" : "") +
               (scene.planar ? R"("planar": true, )" : "") + R"("tolerance": {"force_N": )" +
               number(tolerance.force_N) + R"(, "direction_deg": )" +
               number(tolerance.direction_deg) + R"(, "bandwidth_hz": )" +
               number(tolerance.bandwidth_hz) + "}}";
    }

    static std::string extras_of(const Part &part) {
        std::string members;
        const auto add = [&members](const std::string &member) {
            members += (members.empty() ? "" : ", ") + member;
        };
        if (part.eta) {
            add(R"("eta": )" + number(*part.eta));
        }
        if (part.smooth) {
            add(R"("smooth": true)");
        }
        if (!part.caption.empty()) {
            add(R"("caption": ")" + part.caption + '"');
        }
        return members.empty() ? "" : R"(, "extras": {)" + members + "}";
    }

    void add_part(const Part &part) {
        // Separate statements: within one expression the evaluation order is unspecified.
        const int positions = add_positions(part);
        const int normals = add_normals(part);
        std::string attributes =
            R"("POSITION": )" + number(positions) + R"(, "NORMAL": )" + number(normals);
        if (!part.colours.empty()) {
            attributes += R"(, "COLOR_0": )" + number(add_colours(part));
        }
        const int indices = add_indices(part);
        const auto &[red, green, blue] = part.base_colour;
        const int material = materials_.add(R"({"pbrMetallicRoughness": {"baseColorFactor": [)" +
                                            number(red) + ", " + number(green) + ", " +
                                            number(blue) + R"(, 1], "metallicFactor": 0, )" +
                                            R"("roughnessFactor": 0.5}})"); // satin
        const int mesh =
            meshes_.add(R"({"primitives": [{"attributes": {)" + attributes + R"(}, "indices": )" +
                        number(indices) + R"(, "material": )" + number(material) + "}]}");
        nodes_.add(R"({"name": ")" + part.name + R"(", "mesh": )" + number(mesh) + extras_of(part) +
                   "}");
    }

    int add_view(std::size_t start, int target) {
        return views_.add(R"({"buffer": 0, "byteOffset": )" + number(start) +
                          R"(, "byteLength": )" + number(bytes_.size() - start) +
                          R"(, "target": )" + number(target) + "}");
    }

    int add_accessor(int view, int component_type, std::size_t count, const std::string &type,
                     const std::string &more = "") {
        return accessors_.add(R"({"bufferView": )" + number(view) + R"(, "componentType": )" +
                              number(component_type) + R"(, "count": )" + number(count) +
                              R"(, "type": ")" + type + "\"" + more + "}");
    }

    std::size_t append_vectors(const std::vector<Vector3> &vectors) {
        const std::size_t start = bytes_.size();
        for (const Vector3 &vector : vectors) {
            for (int c = 0; c < 3; ++c) {
                append(bytes_, static_cast<float>(vector[c]));
            }
        }
        return start;
    }

    int add_positions(const Part &part) {
        const int view = add_view(append_vectors(part.positions_m), kArrayBuffer);
        Vector3 lower = part.positions_m.front();
        Vector3 upper = lower;
        for (const Vector3 &position : part.positions_m) {
            lower = lower.cwiseMin(position);
            upper = upper.cwiseMax(position);
        }
        const auto list = [](const Vector3 &v) {
            return "[" + number(static_cast<float>(v.x())) + ", " +
                   number(static_cast<float>(v.y())) + ", " + number(static_cast<float>(v.z())) +
                   "]";
        };
        return add_accessor(view, kFloat, part.positions_m.size(), "VEC3",
                            R"(, "min": )" + list(lower) + R"(, "max": )" + list(upper));
    }

    int add_normals(const Part &part) {
        const int view = add_view(append_vectors(part.normals), kArrayBuffer);
        return add_accessor(view, kFloat, part.normals.size(), "VEC3");
    }

    int add_colours(const Part &part) {
        const std::size_t start = bytes_.size();
        for (const auto &colour : part.colours) {
            append(bytes_, colour);
        }
        return add_accessor(add_view(start, kArrayBuffer), kUnsignedByte, part.colours.size(),
                            "VEC4", R"(, "normalized": true)");
    }

    /// 16 bits suffice for all our shapes, which have fewer than 65,535 vertices each.
    int add_indices(const Part &part) {
        const std::size_t start = bytes_.size();
        for (const auto &triangle : part.triangles) {
            for (const std::uint32_t index : triangle) {
                append(bytes_, static_cast<std::uint16_t>(index));
            }
        }
        const int view = add_view(start, kElementArrayBuffer);
        bytes_.resize((bytes_.size() + 3) / 4 * 4); // floats come next
        return add_accessor(view, kUnsignedShort, 3 * part.triangles.size(), "SCALAR");
    }

    JsonList nodes_;
    JsonList meshes_;
    JsonList materials_;
    JsonList accessors_;
    JsonList views_;
    std::string bytes_;
};

} // namespace

std::string to_gltf(const SceneDescription &scene) { return Writer().write(scene); }

} // namespace springdrive::scenes
