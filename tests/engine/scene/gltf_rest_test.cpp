// Covers engine/scene/gltf_rest.cpp, and skins and instances of gltf_nodes.cpp, against a reader
// that follows the glTF 2.0 specification one vertex at a time and shares no code with the product.
#include "base/input_error.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/engine/scene/gltf_builder.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

namespace springdrive::scene {
namespace {

using nlohmann::json;
using WorldTriangle = std::array<Vector3, 3>;

std::string bytes_of_base64(const std::string &text) {
    std::string bytes;
    unsigned bits = 0;
    unsigned held = 0;
    for (const char c : text) {
        const std::string digits =
            "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        const std::size_t digit = digits.find(c);
        if (digit == std::string::npos) {
            break; // padding
        }
        bits = bits << 6U | static_cast<unsigned>(digit);
        held += 6;
        if (held >= 8) {
            held -= 8;
            bytes += static_cast<char>(bits >> held & 0xffU);
        }
    }
    return bytes;
}

/// The triangles of a file at rest, in its own world, brute force.
class ReferenceScene {
public:
    explicit ReferenceScene(const std::string &file) {
        std::string text = file;
        if (file.starts_with("glTF")) {
            std::uint32_t length = 0;
            std::memcpy(&length, &file[12], 4);
            text = file.substr(20, length);
            buffers_.push_back(file.substr(20 + length + 8));
        }
        document_ = json::parse(text);
        for (const json &buffer : document_["buffers"]) {
            if (buffer.contains("uri")) {
                const std::string uri = buffer["uri"];
                buffers_.push_back(bytes_of_base64(uri.substr(uri.find(',') + 1)));
            }
        }
        const std::size_t scene = document_.value("scene", std::size_t{0});
        for (const std::size_t root : document_["scenes"][scene]["nodes"]) {
            add(root);
        }
    }

    std::vector<WorldTriangle> triangles;
    std::vector<WorldTriangle> normals; ///< of any length; zero where there are none

private:
    [[nodiscard]] std::vector<double> element(std::size_t accessor, std::size_t index) const {
        const json &source = document_["accessors"][accessor];
        const std::string type = source["type"];
        const std::size_t width = type == "SCALAR" ? 1
                                  : type == "MAT4" ? 16
                                                   : static_cast<std::size_t>(type[3] - '0');
        const int component = source["componentType"];
        const std::size_t size = component < 5122 ? 1 : component < 5125 ? 2 : 4;
        const json &view = document_["bufferViews"][source["bufferView"].get<std::size_t>()];
        const std::size_t stride = view.value("byteStride", width * size);
        const std::size_t at = view.value("byteOffset", std::size_t{0}) +
                               source.value("byteOffset", std::size_t{0}) + index * stride;
        const char *const bytes = &buffers_[view["buffer"].get<std::size_t>()][at];
        std::vector<double> numbers;
        for (std::size_t c = 0; c < width; ++c) {
            std::uint16_t integer = 0;
            float real = 0.0F;
            std::memcpy(&integer, bytes + c * size, std::min<std::size_t>(size, sizeof integer));
            std::memcpy(&real, bytes + c * size, std::min<std::size_t>(size, sizeof real));
            double number = component == kFloat   ? static_cast<double>(real)
                            : component == kShort ? static_cast<std::int16_t>(integer)
                                                  : integer;
            if (source.value("normalized", false)) {
                number /= component == kShort ? 32767.0 : 65535.0;
            }
            numbers.push_back(number);
        }
        return numbers;
    }

    [[nodiscard]] Vector3 vector(std::size_t accessor, std::size_t index) const {
        const std::vector<double> numbers = element(accessor, index);
        return {numbers[0], numbers[1], numbers[2]};
    }

    [[nodiscard]] Eigen::Matrix4d local(const json &node) const {
        Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
        if (node.contains("matrix")) {
            for (int i = 0; i < 16; ++i) {
                matrix(i % 4, i / 4) = node["matrix"][static_cast<std::size_t>(i)];
            }
            return matrix;
        }
        if (node.contains("rotation")) {
            const json &q = node["rotation"];
            const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]); // w first
            matrix.topLeftCorner<3, 3>() = rotation.normalized().toRotationMatrix();
        }
        for (int c = 0; c < 3; ++c) {
            const auto i = static_cast<std::size_t>(c);
            matrix.col(c) *= node.contains("scale") ? node["scale"][i].get<double>() : 1.0;
            matrix(c, 3) = node.contains("translation") ? node["translation"][i].get<double>() : 0;
        }
        return matrix;
    }

    [[nodiscard]] Eigen::Matrix4d world(std::size_t node) const {
        const json &nodes = document_["nodes"];
        for (std::size_t parent = 0; parent < nodes.size(); ++parent) {
            const json children = nodes[parent].value("children", json::array());
            if (std::ranges::find(children, json(node)) != children.end()) {
                return world(parent) * local(nodes[node]);
            }
        }
        return local(nodes[node]);
    }

    /// A vertex attribute with its morph targets.
    [[nodiscard]] Vector3 morphed(const json &primitive, const json &weights, const char *name,
                                  std::size_t vertex) const {
        Vector3 sum = vector(primitive["attributes"][name], vertex);
        const json targets = primitive.value("targets", json::array());
        for (std::size_t i = 0; i < std::min(targets.size(), weights.size()); ++i) {
            if (targets[i].contains(name)) {
                sum += weights[i].get<double>() * vector(targets[i][name], vertex);
            }
        }
        return sum;
    }

    /// Where the vertex would be in the world if it were at `point` of the mesh.
    [[nodiscard]] Vector3 placed(const json &primitive, std::size_t node, std::size_t vertex,
                                 const Vector3 &point) const {
        const Eigen::Vector4d p = point.homogeneous();
        const json &owner = document_["nodes"][node];
        const json &attributes = primitive["attributes"];
        if (!owner.contains("skin") || !attributes.contains("JOINTS_0")) {
            return (world(node) * (instance_ * p)).head<3>();
        }
        const json &skin = document_["skins"][owner["skin"].get<std::size_t>()];
        const auto by_joint = [&](double joint) -> Vector3 {
            const auto j = static_cast<std::size_t>(joint);
            Eigen::Matrix4d bind = Eigen::Matrix4d::Identity();
            if (skin.contains("inverseBindMatrices")) {
                const std::vector<double> numbers = element(skin["inverseBindMatrices"], j);
                for (int i = 0; i < 16; ++i) {
                    bind(i % 4, i / 4) = numbers[static_cast<std::size_t>(i)];
                }
            }
            return (world(skin["joints"][j]) * (bind * p)).head<3>();
        };
        Vector3 sum = Vector3::Zero();
        double total = 0.0;
        for (int set = 0; attributes.contains("JOINTS_" + std::to_string(set)); ++set) {
            const auto joints = element(attributes["JOINTS_" + std::to_string(set)], vertex);
            const auto weights = element(attributes["WEIGHTS_" + std::to_string(set)], vertex);
            for (std::size_t i = 0; i < 4; ++i) {
                if (weights[i] != 0.0) {
                    sum += weights[i] * by_joint(joints[i]);
                    total += weights[i];
                }
            }
        }
        return total > 0.0 ? Vector3(sum / total)
                           : by_joint(element(attributes["JOINTS_0"], vertex)[0]);
    }

    /// By the inverse transpose of what moves the points around it.
    [[nodiscard]] Vector3 normal_of(const json &primitive, const json &weights, std::size_t node,
                                    std::size_t vertex) const {
        if (!primitive["attributes"].contains("NORMAL")) {
            return Vector3::Zero();
        }
        const Vector3 p = morphed(primitive, weights, "POSITION", vertex);
        Matrix3 M;
        for (int c = 0; c < 3; ++c) {
            M.col(c) = placed(primitive, node, vertex, p + Vector3::Unit(c)) -
                       placed(primitive, node, vertex, p);
        }
        if (std::abs(M.determinant()) < 1e-3) {
            return Vector3::Zero(); // flattened: not compared
        }
        return M.inverse().transpose() * morphed(primitive, weights, "NORMAL", vertex);
    }

    /// How many of the node's mesh there are, and where the given one is beside the node.
    [[nodiscard]] std::size_t instances(const json &node) const {
        if (!node.contains("extensions")) {
            return 1;
        }
        const json &attributes = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
        return document_["accessors"][attributes.begin()->get<std::size_t>()]["count"];
    }
    [[nodiscard]] Eigen::Matrix4d instance(const json &node, std::size_t index) const {
        json local_node = json::object();
        if (node.contains("extensions")) {
            for (const auto &[name, accessor] :
                 node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"].items()) {
                const char *const member = name == "TRANSLATION" ? "translation"
                                           : name == "SCALE"     ? "scale"
                                                                 : "rotation";
                local_node[member] = element(accessor, index);
            }
        }
        return local(local_node);
    }

    void add(std::size_t index) {
        const json &node = document_["nodes"][index];
        for (std::size_t i = 0; node.contains("mesh") && i < instances(node); ++i) {
            instance_ = instance(node, i);
            const json &mesh = document_["meshes"][node["mesh"].get<std::size_t>()];
            const json weights = node.value("weights", mesh.value("weights", json::array()));
            for (const json &primitive : mesh["primitives"]) {
                add(primitive, weights, index);
            }
        }
        for (const std::size_t child : node.value("children", json::array())) {
            add(child);
        }
    }

    void add(const json &primitive, const json &weights, std::size_t node) {
        const std::size_t indices = primitive["indices"];
        const std::size_t count = document_["accessors"][indices]["count"];
        for (std::size_t i = 0; i + 2 < count; i += 3) {
            triangles.emplace_back();
            normals.emplace_back();
            for (std::size_t c = 0; c < 3; ++c) {
                const auto vertex = static_cast<std::size_t>(element(indices, i + c)[0]);
                triangles.back()[c] = placed(primitive, node, vertex,
                                             morphed(primitive, weights, "POSITION", vertex));
                normals.back()[c] = normal_of(primitive, weights, node, vertex);
            }
        }
    }

    json document_;
    std::vector<std::string> buffers_;
    Eigen::Matrix4d instance_ = Eigen::Matrix4d::Identity(); ///< that is added
};

/// The reference's triangles are what is touched, up to their winding; what is touched is what is
/// drawn, winding and normals included.
void expect_as_reference(const Scene &scene, const ReferenceScene &reference) {
    const std::vector<WorldTriangle> touched = corners_of(scene.surface);
    ASSERT_EQ(touched.size(), reference.triangles.size());
    BoundingBox box;
    for (const WorldTriangle &triangle : reference.triangles) {
        for (const Vector3 &corner : triangle) {
            box.include(corner);
        }
    }
    Fit fit;
    if (!scene.in_metres) {
        fit = {0.5 * (box.lower + box.upper), 0.5 * (scene.lower_m + scene.upper_m),
               scene.metres_per_unit};
    }
    const double rounding_m = 1e-9 * (1.0 + scene.lower_m.norm() + scene.upper_m.norm());
    std::vector<std::array<VisualVertex, 3>> drawn;
    for (const VisualMesh &mesh : scene.meshes) {
        for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
            drawn.push_back({mesh.vertices[mesh.indices[i]], mesh.vertices[mesh.indices[i + 1]],
                             mesh.vertices[mesh.indices[i + 2]]});
        }
    }
    ASSERT_EQ(drawn.size(), touched.size());
    const auto to_vector = [](const std::array<float, 3> &v) {
        return Vector3(static_cast<double>(v[0]), static_cast<double>(v[1]),
                       static_cast<double>(v[2]));
    };
    for (std::size_t i = 0; i < touched.size(); ++i) {
        const bool is_turned = (touched[i][1] - fit(reference.triangles[i][1])).norm() > rounding_m;
        for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t there = is_turned ? (3 - c) % 3 : c;
            ASSERT_LT((touched[i][c] - fit(reference.triangles[i][there])).norm(), rounding_m)
                << "triangle " << i << ", corner " << c;
            EXPECT_LT((to_vector(drawn[i][c].position_m) - touched[i][c]).norm(),
                      1e-6 * (1.0 + touched[i][c].norm()));
            const Vector3 &normal = reference.normals[i][there];
            if (normal.norm() > 0.0) {
                EXPECT_LT((to_vector(drawn[i][c].normal) - normal.normalized()).norm(), 1e-4)
                    << "triangle " << i << ", corner " << c;
            }
        }
    }
}

/// Files with a random tree of nodes, meshes with morph targets, and skins.
class RandomFile {
public:
    explicit RandomFile(std::uint64_t seed) : random_(seed) {
        builder_.asset = kMetres;
        const int nodes = whole(4, 8);
        const int skins = whole(1, 2);
        const std::array<std::size_t, 2> targets{add_mesh(nodes), add_mesh(nodes)};
        std::string list;
        for (int i = 0; i < skins; ++i) {
            list += (i == 0 ? "" : ", ") + skin(nodes);
        }
        builder_.more = R"("scene": 0, "skins": [)" + list + "], ";
        add_nodes(nodes, skins, targets);
    }

    [[nodiscard]] const GltfBuilder &builder() const { return builder_; }

private:
    double real(double lowest, double highest) {
        return std::uniform_real_distribution(lowest, highest)(random_);
    }
    int whole(int lowest, int highest) {
        return std::uniform_int_distribution(lowest, highest)(random_);
    }
    bool chance(double probability) { return real(0.0, 1.0) < probability; }

    std::vector<float> reals(std::size_t count, double size) {
        std::vector<float> numbers(count);
        std::ranges::generate(numbers, [&] { return static_cast<float>(real(-size, size)); });
        return numbers;
    }
    std::string text_of(const std::vector<float> &numbers) {
        std::string text;
        for (const float number : numbers) {
            text += (text.empty() ? "[" : ", ") + std::to_string(number);
        }
        return text + "]";
    }

    /// JOINTS_n and WEIGHTS_n, whose weights rarely add up to one; a vertex may have none.
    std::string joint_set(int n, std::size_t vertices, int max_joint) {
        std::vector<std::uint8_t> joints(4 * vertices);
        std::vector<float> weights(4 * vertices);
        for (std::size_t i = 0; i < joints.size(); ++i) {
            weights[i] = chance(0.3) ? 0.0F : static_cast<float>(real(0.0, 1.0));
            const bool is_meant = weights[i] != 0.0F || (n == 0 && i % 4 == 0);
            joints[i] = static_cast<std::uint8_t>(is_meant ? whole(0, max_joint) : 255);
        }
        const int joints_at =
            chance(0.5)
                ? builder_.add_accessor(joints, kUnsignedByte, "VEC4")
                : builder_.add_accessor(std::vector<std::uint16_t>(joints.begin(), joints.end()),
                                        kUnsignedShort, "VEC4");
        int weights_at = 0;
        if (chance(0.5)) {
            weights_at = builder_.add_accessor(weights, kFloat, "VEC4");
        } else {
            std::vector<std::uint16_t> shorts;
            for (const float weight : weights) {
                shorts.push_back(static_cast<std::uint16_t>(65535.0F * weight));
            }
            weights_at =
                builder_.add_accessor(shorts, kUnsignedShort, "VEC4", R"(, "normalized": true)");
        }
        return R"(, "JOINTS_)" + std::to_string(n) + "\": " + std::to_string(joints_at) +
               R"(, "WEIGHTS_)" + std::to_string(n) + "\": " + std::to_string(weights_at);
    }

    /// @return its number of morph targets
    std::size_t add_mesh(int nodes) {
        const auto vertices = static_cast<std::size_t>(whole(3, 9));
        const bool has_normals = chance(0.5);
        std::vector<std::uint16_t> indices(3 * static_cast<std::size_t>(whole(1, 6)));
        std::ranges::generate(indices, [&] {
            return static_cast<std::uint16_t>(whole(0, static_cast<int>(vertices) - 1));
        });
        const auto attribute = [&](const char *name, double size) {
            return '"' + std::string(name) +
                   "\": " + std::to_string(builder_.add_positions(reals(3 * vertices, size)));
        };
        std::string attributes = attribute("POSITION", 1.0);
        attributes += has_normals ? ", " + attribute("NORMAL", 1.0) : "";
        for (int n = 0; n < whole(0, 2); ++n) {
            attributes += joint_set(n, vertices, nodes / 2 - 1);
        }
        std::string targets;
        const auto target_count = static_cast<std::size_t>(whole(0, 3));
        for (std::size_t i = 0; i < target_count; ++i) {
            targets += (i == 0 ? "{" : ", {") + attribute("POSITION", 0.5) +
                       (chance(0.5) ? ", " + attribute("NORMAL", 0.2) : "") + "}";
        }
        const std::string weights =
            chance(0.5) ? R"(, "weights": )" + text_of(reals(target_count, 1.0)) : "";
        builder_.meshes.push_back(
            R"({"primitives": [{"attributes": {)" + attributes + R"(}, "indices": )" +
            std::to_string(builder_.add_accessor(indices, kUnsignedShort, "SCALAR")) +
            (target_count == 0 ? "}]}" : R"(, "targets": [)" + targets + "]}]" + weights + "}"));
        return target_count;
    }

    std::string skin(int nodes) {
        std::string joints;
        for (int i = 0; i < nodes / 2; ++i) {
            joints += (i == 0 ? "" : ", ") + std::to_string(whole(0, nodes - 1));
        }
        if (chance(0.3)) {
            return R"({"joints": [)" + joints + "]}";
        }
        std::vector<float> matrices = reals(16 * static_cast<std::size_t>(nodes / 2), 1.5);
        for (std::size_t i = 3; i < matrices.size(); i += 4) {
            matrices[i] = i % 16 == 15 ? 1.0F : 0.0F;
        }
        return R"({"joints": [)" + joints + R"(], "inverseBindMatrices": )" +
               std::to_string(builder_.add_accessor(matrices, kFloat, "MAT4")) + "}";
    }

    std::string instances() {
        const auto count = static_cast<std::size_t>(whole(1, 4));
        std::string attributes =
            R"("TRANSLATION": )" + std::to_string(builder_.add_positions(reals(3 * count, 2.0)));
        if (chance(0.5)) {
            std::vector<std::int16_t> quaternions;
            for (std::size_t i = 0; i < count; ++i) {
                const Eigen::Vector4d q = Eigen::Vector4d(real(-1, 1), real(-1, 1), real(-1, 1), 1);
                for (const double part : q.normalized()) {
                    quaternions.push_back(static_cast<std::int16_t>(std::lround(32767.0 * part)));
                }
            }
            attributes += R"(, "ROTATION": )" +
                          std::to_string(builder_.add_accessor(quaternions, kShort, "VEC4",
                                                               R"(, "normalized": true)"));
        }
        attributes +=
            chance(0.5)
                ? R"(, "SCALE": )" + std::to_string(builder_.add_positions(reals(3 * count, 1.5)))
                : "";
        return R"({"EXT_mesh_gpu_instancing": {"attributes": {)" + attributes + "}}}";
    }

    void add_nodes(int nodes, int skins, const std::array<std::size_t, 2> &targets) {
        std::vector<std::string> children(static_cast<std::size_t>(nodes));
        std::vector<std::string> roots;
        for (int i = 0; i < nodes; ++i) {
            const std::string name = std::to_string(i);
            if (i == 0 || chance(0.3)) {
                roots.push_back(name);
            } else {
                std::string &list = children[static_cast<std::size_t>(whole(0, i - 1))];
                list += (list.empty() ? "" : ", ") + name;
            }
        }
        for (int i = 0; i < nodes; ++i) {
            const Eigen::Quaterniond q =
                Eigen::Quaterniond(1.0, real(-1, 1), real(-1, 1), real(-1, 1)).normalized();
            std::string members =
                chance(0.2)
                    ? R"("matrix": [1, 0.5, 0, 0, -0.25, -1, 0.5, 0, 0, 0, 1, 0, 1, 2, 3, 1])"
                    : R"("translation": )" + text_of(reals(3, 1.0)) + R"(, "scale": )" +
                          text_of(reals(3, 1.5)) + R"(, "rotation": )" +
                          text_of({static_cast<float>(q.x()), static_cast<float>(q.y()),
                                   static_cast<float>(q.z()), static_cast<float>(q.w())});
            if (!children[static_cast<std::size_t>(i)].empty()) {
                members += R"(, "children": [)" + children[static_cast<std::size_t>(i)] + "]";
            }
            if (i == 0 || chance(0.6)) {
                const int mesh = whole(0, 1);
                members += R"(, "mesh": )" + std::to_string(mesh);
                members += chance(0.6)   ? R"(, "skin": )" + std::to_string(whole(0, skins - 1))
                           : chance(0.5) ? R"(, "extensions": )" + instances()
                                         : "";
                const std::size_t count = targets[static_cast<std::size_t>(mesh)];
                members +=
                    count > 0 && chance(0.5) ? R"(, "weights": )" + text_of(reals(count, 1.0)) : "";
            }
            builder_.nodes.push_back("{" + members + "}");
        }
        if (roots.size() > 1 && chance(0.5)) {
            roots.pop_back(); // joints may be outside the scene
        }
        std::string list;
        for (const std::string &root : roots) {
            list += (list.empty() ? "" : ", ") + root;
        }
        builder_.scenes = {R"({"nodes": [)" + list + "]}"};
    }

    std::mt19937_64 random_;
    GltfBuilder builder_;
};

TEST(GltfRest, SkinsMorphTargetsAndInstancesAreWhereTheSpecificationsPutThem) {
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const std::string file = RandomFile(seed).builder().gltf();
        expect_as_reference(load_bytes(file), ReferenceScene(file));
        if (HasFatalFailure()) {
            return;
        }
    }
}

/// Of the files that a folder beside the models has.
std::string read_case(const std::string &name) {
    std::ifstream stream(std::filesystem::path(SPRINGDRIVE_MODELS_DIR) / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(GltfRest, FilesOfOtherProgramsAreAsTheReferenceHasThem) {
    for (const std::string name :
         {"../cases/gltf/skinned_armature_scale_0.01.gltf", "../cases/gltf/instancing_5_cubes.gltf",
          "Box.glb", "ShapeCollection.glb"}) {
        SCOPED_TRACE(name);
        const std::string file = read_case(name);
        if (file.empty()) {
            GTEST_SKIP() << "there is no " << name;
        }
        expect_as_reference(load_bytes(file), ReferenceScene(file));
    }
}

/// The tetrahedron with unit legs along the axes, of volume 1/6, held by the joints 1 and 2.
struct HeldTetrahedron {
    std::vector<std::uint8_t> joints = std::vector<std::uint8_t>(16, 0);
    std::vector<float> weights = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    std::string skin = R"("joints": [1, 2])";
    std::string owner = R"("scale": [-3, 1, 1])"; // of no meaning
    std::string joint;
    std::string others;

    [[nodiscard]] GltfBuilder builder() const {
        GltfBuilder builder;
        builder.asset = kMetres;
        builder.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
        builder.add_accessor(std::vector<std::uint8_t>{0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3},
                             kUnsignedByte, "SCALAR");
        builder.add_accessor(joints, kUnsignedByte, "VEC4");
        builder.add_accessor(weights, kFloat, "VEC4");
        std::vector<float> matrices(32, 0.0F); // the identity, and no finite one
        for (std::size_t i = 0; i < 16; i += 5) {
            matrices[i] = 1.0F;
        }
        matrices[16] = NAN;
        builder.add_accessor(matrices, kFloat, "MAT4");
        builder.add_mesh(
            R"("attributes": {"POSITION": 0, "JOINTS_0": 2, "WEIGHTS_0": 3}, "indices": 1)");
        builder.nodes = {R"({"name": "held", "mesh": 0, "skin": 0, )" + owner + "}",
                         "{" + joint + "}", "{}"};
        builder.scenes = {R"({"nodes": [0]})"};
        if (!others.empty()) {
            builder.nodes.push_back(others);
        }
        builder.more = R"("skins": [{)" + skin + "}], ";
        return builder;
    }
};

TEST(GltfRest, SkinsThatMirrorAreStillWoundOutwards) {
    for (const char *scale : {"[1, 1, 1]", "[-1, 1, 1]", "[1, -1, -1]", "[-1, -1, -1]"}) {
        HeldTetrahedron held;
        held.joint = R"("scale": )" + std::string(scale);
        EXPECT_DOUBLE_EQ(volume_of(load(held.builder()).surface), 1.0 / 6.0) << scale;
    }
}

TEST(GltfRest, VerticesWithoutAWeightFollowTheirFirstJointAndAreTold) {
    HeldTetrahedron held;
    held.joint = R"("translation": [5, 0, 0])";
    held.weights[4] = 0.0F;
    held.joints[5] = 77; // with no weight, of no meaning
    const Scene scene = load(held.builder());
    EXPECT_EQ(scene.surface.vertices_m[1], Vector3(6, 0, 0));
    EXPECT_TRUE(has_warning(scene, "node 'held': 1 vertices have no weight"));
}

TEST(GltfRest, PrimitivesWithoutJointsStayWhereTheirNodeIs) {
    HeldTetrahedron held;
    held.joint = R"("translation": [5, 0, 0])";
    GltfBuilder builder = held.builder();
    builder.meshes = {R"({"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]})"};
    const Scene scene = load(builder);
    EXPECT_EQ(scene.surface.vertices_m[1], Vector3(-3, 0, 0));
    EXPECT_DOUBLE_EQ(volume_of(scene.surface), 3.0 / 6.0);
    EXPECT_TRUE(has_warning(scene, "node 'held': a primitive has no JOINTS_0"));
}

TEST(GltfRest, RefusesSkinsThatCannotBe) {
    const auto failing = [](const HeldTetrahedron &held, const std::string &part) {
        const std::string message = failure_of(held.builder());
        EXPECT_NE(message.find("node 'held': "), std::string::npos) << message;
        EXPECT_NE(message.find(part), std::string::npos) << message;
    };
    HeldTetrahedron held;
    held.weights[5] = 0.5F;
    held.joints[5] = 2;
    failing(held, "JOINTS_0 of vertex 1 is 2; the skin has 2 joints");
    held.joints[5] = 1;
    EXPECT_NO_THROW(load(held.builder()));
    held.weights[5] = -0.5F;
    failing(held, "WEIGHTS_0 of vertex 1 is -0.5");
    held.weights[5] = NAN;
    failing(held, "WEIGHTS_0 of vertex 1 is not finite");
    const auto with_skin = [](const std::string &skin) {
        HeldTetrahedron other;
        other.skin = skin;
        return other;
    };
    failing(with_skin(R"("joints": [1, 7])"), "skin 0: joint 7 is not in the file");
    failing(with_skin(R"("joints": [])"), "JOINTS_0 of vertex 0 is 0; the skin has 0 joints");
    failing(with_skin(R"("joints": [1], "inverseBindMatrices": 3)"),
            "accessor 3: it takes 1 matrices");
    failing(with_skin(R"("joints": [1, 1, 1], "inverseBindMatrices": 4)"),
            "accessor 4: it takes 3 matrices");
    HeldTetrahedron wild = with_skin(R"("joints": [1, 1], "inverseBindMatrices": 4)");
    EXPECT_NO_THROW(load(wild.builder())); // the second matrix is not finite, and not used
    wild.joints[4] = 1;
    failing(wild, "of vertex 1 is not finite");
    HeldTetrahedron ring; // of joints outside the scene
    ring.joint = R"("children": [3])";
    ring.others = R"({"children": [1]})";
    failing(ring, "is reached twice");
    ring.joint = "";
    ring.others = R"({"children": [1, 1]})";
    failing(ring, "node 1 is reached twice");
    GltfBuilder builder = HeldTetrahedron().builder();
    builder.more.clear();
    expect_failure(builder, "node 'held': skin 0: skin 0 is not in the file");
}

TEST(GltfRest, AChainOfManyJointsOutsideTheSceneNeedsNoRecursion) {
    constexpr int kDepth = 50'000;
    HeldTetrahedron held;
    held.skin = R"("joints": [1)";
    GltfBuilder builder = held.builder();
    builder.nodes.resize(1);
    std::string joints = "1";
    for (int i = 1; i <= kDepth; ++i) {
        builder.nodes.push_back(i == 1 ? R"({"translation": [1, 0, 0]})"
                                       : R"({"children": [)" + std::to_string(i - 1) + "]}");
        joints += ", " + std::to_string(i);
    }
    builder.more = R"("skins": [{"joints": [)" + joints + "]}], ";
    EXPECT_EQ(load(builder).surface.vertices_m[1], Vector3(2, 0, 0));
}

/// A triangle whose targets push along z by 1, and by what is not finite.
GltfBuilder with_targets(const std::string &weights, const std::string &of_node) {
    GltfBuilder builder = one_triangle(of_node);
    builder.add_positions({0, 0, 1, 0, 0, 1, 0, 0, 1});
    builder.add_positions({0, 0, 0, 0, NAN, 0, 0, 0, 0});
    builder.meshes = {R"({"primitives": [{"attributes": {"POSITION": 0},
        "targets": [{"POSITION": 1}, {"POSITION": 2}, {"POSITION": 1}]}])" +
                      weights + "}"};
    return builder;
}

TEST(GltfRest, WeightsThatMatchNoTargetAreTold) {
    const auto z_of = [](const std::string &weights, bool is_told) {
        const Scene scene = load(with_targets("", R"("weights": )" + weights));
        EXPECT_EQ(has_warning(scene, "weights for 3 morph targets"), is_told) << weights;
        return scene.surface.vertices_m[0].z();
    };
    EXPECT_EQ(z_of("[-2, 0, 0]", false), -2.0);
    EXPECT_EQ(z_of("[0.5]", true), 0.5);
    EXPECT_EQ(z_of("[0.5, 0, 0, 9]", true), 0.5);
    EXPECT_EQ(z_of("[]", false), 0.0);
}

TEST(GltfRest, RefusesTargetsThatCannotBe) {
    expect_failure(with_targets(R"(, "weights": [0, 1, 0])", ""),
                   "node 0: a morph target's POSITION of vertex 1 is not finite");
    expect_failure(with_targets("", R"("weights": [1e308, 0, 1e308])"),
                   "POSITION at rest of vertex 0 is not finite");
    GltfBuilder builder = with_targets(R"(, "weights": [1])", "");
    builder.accessors[1].replace(builder.accessors[1].find("\"count\": 3"), 10, "\"count\": 2");
    expect_failure(builder, "a morph target's POSITION has 2 entries for 3 vertices");
}

/// Three instances of a triangle.
GltfBuilder with_instances(const std::string &attributes, const std::string &members = "") {
    GltfBuilder builder = one_triangle(R"("name": "grass", "extensions": {"EXT_mesh_gpu_instancing":
        {"attributes": {)" + attributes +
                                       "}}}" + members);
    builder.add_positions({0, 0, 0, 2, 0, 0, 4, 0, NAN});
    builder.add_accessor(std::vector<float>{0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0}, kFloat, "VEC4");
    builder.add_positions({1, 1, 1, -1, 1, 1, 1, 1, 1});
    builder.add_positions({0, 0, 0, 2, 0, 0});
    builder.accessors.emplace_back(R"({"componentType": 5126, "count": 65536, "type": "VEC3"})");
    builder.accessors.emplace_back(R"({"componentType": 5126, "count": 65537, "type": "VEC3"})");
    return builder;
}

TEST(GltfInstances, EachIsTouchedWoundOutwardsAndNamedAsItsNode) {
    const Scene scene = load(with_instances(R"("SCALE": 3, "_ID": 9)",
                                            R"(, "extras": {"caption": "grass", "eta": 0.5})"));
    ASSERT_EQ(scene.surface.triangles.size(), 3U);
    for (const auto &[a, b, c] : corners_of(scene.surface)) {
        EXPECT_GT((b - a).cross(c - a).z(), 0.0); // also of the mirrored one
    }
    ASSERT_EQ(scene.surface.materials.size(), 3U);
    EXPECT_EQ(scene.surface.materials[2].name, "grass");
    EXPECT_EQ(scene.surface.materials[2].eta, 0.5);
    EXPECT_EQ(scene.captions.size(), 1U);
    EXPECT_EQ(load(with_instances(R"("_ID": 9)")).surface.triangles.size(), 1U);
}

TEST(GltfInstances, ASkinPlacesItsMeshOnce) {
    GltfBuilder builder = with_instances(R"("SCALE": 3)", R"(, "skin": 0)");
    builder.more = R"("skins": [{"joints": [0]}], )";
    const Scene scene = load(builder);
    EXPECT_EQ(scene.surface.triangles.size(), 1U);
    EXPECT_TRUE(has_warning(scene, "node 'grass': its instances are left out"));
}

TEST(GltfInstances, RefusesThoseThatCannotBe) {
    for (const auto &[attributes, part] : std::vector<std::pair<std::string, std::string>>{
             {R"("TRANSLATION": 1)", "the transform of instance 2 is not finite"},
             {R"("ROTATION": 2)", "instance 2: its rotation is a quaternion of length 0"},
             {R"("ROTATION": 3)", "ROTATION: ROTATION has 3 numbers"},
             {R"("SCALE": 3, "TRANSLATION": 4)", "its SCALE: it has 3 instances"},
             {R"("SCALE": 77)", "its SCALE: accessor 77 is not in the file"},
             {R"("SCALE": "3")", "its SCALE: it must be the number of an accessor"},
             {R"("TRANSLATION": 6)", "its TRANSLATION: it has 65537 instances; at most 65536"}}) {
        expect_failure(with_instances(attributes), "node 'grass': ");
        expect_failure(with_instances(attributes), part);
    }
    EXPECT_EQ(load(with_instances(R"("TRANSLATION": 5)")).surface.triangles.size(), 65'536U);
    GltfBuilder builder = with_instances(R"("TRANSLATION": 5)");
    builder.nodes.insert(builder.nodes.begin(), R"({"mesh": 0})");
    expect_failure(builder, "node 'grass': with its 65536 instances");
    builder.nodes = {
        R"({"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": 1}}})"};
    expect_failure(builder, "node 0: EXT_mesh_gpu_instancing needs attributes");
}

/// What nodes share may not make a small file much work: weights, sets of joints, targets.
TEST(GltfRest, WorkThatNodesShareIsBounded) {
    std::string zeros = "0";
    for (int i = 1; i < 200'000; ++i) {
        zeros += ",0";
    }
    GltfBuilder builder = with_targets(R"(, "weights": [)" + zeros + "]", "");
    builder.nodes.assign(195, R"({"mesh": 0})"); // 39 million numbers
    EXPECT_NO_THROW(load(builder));
    builder.nodes.assign(196, R"({"mesh": 0})");
    expect_failure(builder, "at most 8 GiB are allowed");
    builder = HeldTetrahedron().builder();
    std::string sets;
    for (int i = 0; i < 20; ++i) {
        sets += R"(, "JOINTS_)" + std::to_string(i) + "\": 2";
    }
    builder.accessors[0] = R"({"componentType": 5126, "count": 2000000, "type": "VEC3"})";
    builder.meshes = {R"({"primitives": [{"attributes": {"POSITION": 0)" + sets +
                      R"(}, "indices": 1}]})"};
    expect_failure(builder, "at most 8 GiB are allowed");
}

} // namespace
} // namespace springdrive::scene
