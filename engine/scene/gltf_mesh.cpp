#include "engine/scene/gltf_mesh.h"

#include "base/assertions.h"
#include "base/cancellation.h"
#include "base/degrees.h"
#include "base/input_error.h"
#include "base/text.h"
#include "engine/scene/curved_patches.h"
#include "engine/scene/visual_mesh.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

namespace springdrive::scene::gltf {

namespace {

/// Reads a primitive's attributes from accessors, or from its Draco data where these hold them.
class AttributeSource {
public:
    AttributeSource(const tinygltf::Model &model, const tinygltf::Primitive &primitive)
        : model_(model), primitive_(primitive) {
        const auto draco = primitive.extensions.find(kDracoExtension);
        if (draco == primitive.extensions.end()) {
            return;
        }
        const tinygltf::Value &extension = draco->second;
        if (!extension.IsObject() || !extension.Get("bufferView").IsInt() ||
            !extension.Get("attributes").IsObject()) {
            throw InputError(std::string(kDracoExtension) + " needs bufferView and attributes");
        }
        draco_attributes_ = extension.Get("attributes");
        draco_.emplace(view_bytes(model, extension.Get("bufferView").GetNumberAsInt()));
    }

    [[nodiscard]] const DracoMesh *draco() const { return draco_ ? &*draco_ : nullptr; }

    [[nodiscard]] Attribute read(const std::string &name, Scaling scaling) const {
        const auto found = primitive_.attributes.find(name);
        if (found == primitive_.attributes.end()) {
            return {};
        }
        const int accessor = found->second;
        if (!draco_ || !draco_attributes_.Has(name)) {
            return read_attribute(model_, accessor, scaling);
        }
        const bool normalised = scaling == Scaling::unit_range || is_normalised(model_, accessor);
        const tinygltf::Value &id = draco_attributes_.Get(name);
        if (!id.IsInt()) {
            throw InputError(std::string(kDracoExtension) + ": the id of " + name +
                             " is no integer");
        }
        return draco_->attribute(static_cast<std::uint32_t>(id.GetNumberAsInt()), normalised);
    }

private:
    const tinygltf::Model &model_;
    const tinygltf::Primitive &primitive_;
    tinygltf::Value draco_attributes_;
    std::optional<DracoMesh> draco_;
};

void check_in_range(const std::vector<Triangle> &triangles, std::size_t vertex_count) {
    for (const Triangle &triangle : triangles) {
        for (const std::uint32_t index : triangle) {
            if (index >= vertex_count) {
                throw InputError("index " + std::to_string(index) + " is out of range; there are " +
                                 std::to_string(vertex_count) + " vertices");
            }
        }
    }
}

/// Notes what a primitive of points or lines holds.
void note_untouchable(int mode, std::size_t corners, PrimitiveGeometry &geometry) {
    switch (mode) {
    case TINYGLTF_MODE_POINTS:
        geometry.untouchable = "points";
        geometry.untouchable_count = corners;
        return;
    case TINYGLTF_MODE_LINE:
        geometry.untouchable_count = corners / 2;
        break;
    case TINYGLTF_MODE_LINE_LOOP:
        geometry.untouchable_count = corners;
        break;
    case TINYGLTF_MODE_LINE_STRIP:
        geometry.untouchable_count = corners - std::min<std::size_t>(corners, 1);
        break;
    default:
        return;
    }
    geometry.untouchable = "line segments";
}

std::vector<std::uint32_t> read_corners(const tinygltf::Model &model,
                                        const tinygltf::Primitive &primitive,
                                        std::size_t vertex_count) {
    if (primitive.indices >= 0) {
        return read_indices(model, primitive.indices);
    }
    std::vector<std::uint32_t> corners(vertex_count);
    std::iota(corners.begin(), corners.end(), 0U);
    return corners;
}

void read_triangles(const tinygltf::Model &model, const tinygltf::Primitive &primitive,
                    const DracoMesh *draco, PrimitiveGeometry &geometry) {
    if (draco != nullptr) {
        geometry.triangles = draco->triangles();
        return;
    }
    const std::vector<std::uint32_t> corners =
        read_corners(model, primitive, geometry.position.count());
    geometry.triangles = assemble_triangles(primitive.mode, corners);
    geometry.leftover_vertices = primitive.mode == TINYGLTF_MODE_TRIANGLES ? corners.size() % 3
                                 : corners.size() < 3                      ? corners.size()
                                                                           : 0;
}

/// A node that mirrors turns its triangles inside out, so they are wound the other way round.
bool mirrors(const PlacedMesh &node) { return node.to_world.linear().determinant() < 0.0; }

Triangle wound_outwards(const Triangle &triangle, bool mirrored) {
    return mirrored ? Triangle{triangle[0], triangle[2], triangle[1]} : triangle;
}

std::array<float, 3> to_floats(const Vector3 &vector) {
    return {static_cast<float>(vector.x()), static_cast<float>(vector.y()),
            static_cast<float>(vector.z())};
}

std::array<float, 4> world_tangent(const PlacedPrimitive &primitive, std::size_t vertex) {
    const std::span<const double> tangent = primitive.geometry->tangent[vertex];
    const Vector3 along =
        (primitive.node->to_world.linear() * Vector3(tangent.data())).stableNormalized();
    const double sign = mirrors(*primitive.node) ? -tangent[3] : tangent[3];
    const std::array<float, 3> unit = to_floats(along);
    return {unit[0], unit[1], unit[2], sign < 0.0 ? -1.0F : 1.0F};
}

std::array<float, 3> unit_or_up(const Vector3 &vector) {
    const double length = vector.stableNorm();
    return length > 0.0 && std::isfinite(length) ? to_floats(vector / length)
                                                 : std::array<float, 3>{0.0F, 1.0F, 0.0F};
}

VisualVertex visual_vertex(const PlacedPrimitive &primitive, std::size_t i) {
    const DrawnMaterial &material = primitive.material;
    VisualVertex vertex{to_floats(primitive.positions[i]), {0.0F, 1.0F, 0.0F}, {}, {}};
    const Attribute &colour = primitive.geometry->colour;
    for (std::size_t c = 0; c < 4; ++c) {
        const bool given = !colour.empty() && c < static_cast<std::size_t>(colour.components);
        vertex.colour[c] =
            static_cast<float>(material.base_factor[c] * (given ? colour[i][c] : 1.0));
    }
    if (material.alpha_mode == AlphaMode::opaque) {
        vertex.colour[3] = 1.0F;
    }
    if (!primitive.geometry->texture_coordinate.empty()) {
        const std::span<const double> uv = primitive.geometry->texture_coordinate[i];
        const std::array<double, 2> placed = material.transform(uv[0], uv[1]);
        vertex.texture_coordinate = {static_cast<float>(placed[0]), static_cast<float>(placed[1])};
    }
    return vertex;
}

/// With the file's normals: vertices shared as they are.
void add_smooth(const PlacedPrimitive &primitive, VisualMesh &mesh) {
    const bool mirrored = mirrors(*primitive.node);
    mesh.vertices.reserve(primitive.positions.size());
    mesh.indices.reserve(3 * primitive.geometry->triangles.size());
    for (std::size_t i = 0; i < primitive.positions.size(); ++i) {
        stop_if_given_up(i);
        VisualVertex vertex = visual_vertex(primitive, i);
        vertex.normal = unit_or_up(world_normal(primitive, i));
        mesh.vertices.push_back(vertex);
        if (!primitive.geometry->tangent.empty() && mesh.finish.normal_texture >= 0) {
            mesh.tangents.push_back(world_tangent(primitive, i));
        }
    }
    for (const Triangle &local : primitive.geometry->triangles) {
        const Triangle triangle = wound_outwards(local, mirrored);
        mesh.indices.insert(mesh.indices.end(), triangle.begin(), triangle.end());
    }
}

/// Without normals in the file, glTF requires flat ones: each triangle has its own three vertices.
void add_flat(const PlacedPrimitive &primitive, VisualMesh &mesh) {
    const bool mirrored = mirrors(*primitive.node);
    mesh.vertices.reserve(3 * primitive.geometry->triangles.size());
    mesh.indices.reserve(3 * primitive.geometry->triangles.size());
    for (const Triangle &local : primitive.geometry->triangles) {
        const Triangle triangle = wound_outwards(local, mirrored);
        stop_if_given_up(mesh.vertices.size() / 3);
        const Vector3 &corner = primitive.positions[triangle[0]];
        const Vector3 edge_1 = primitive.positions[triangle[1]] - corner;
        const Vector3 edge_2 = primitive.positions[triangle[2]] - corner;
        const std::array<float, 3> normal = unit_or_up(edge_1.cross(edge_2));
        for (const std::uint32_t index : triangle) {
            mesh.indices.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
            mesh.vertices.push_back(visual_vertex(primitive, index));
            mesh.vertices.back().normal = normal;
        }
    }
}

bool has_alpha(const VisualMesh &mesh) {
    constexpr float kOpaque = 0.999F;
    return std::ranges::any_of(mesh.vertices,
                               [](const VisualVertex &v) { return v.colour[3] < kOpaque; });
}

/// Textures, finish and emission of `mesh`.
void add_material(const PlacedPrimitive &primitive, TextureLibrary &textures, WarningList &warnings,
                  VisualMesh &mesh) {
    const PlacedMesh &node = *primitive.node;
    const DrawnMaterial &material = primitive.material;
    const bool has_emissive_texture = material.emissive_texture >= 0;
    Finish &finish = mesh.finish;
    finish.metallic = static_cast<float>(material.metallic);
    finish.roughness = static_cast<float>(material.roughness);
    finish.normal_scale = static_cast<float>(material.normal_scale);
    finish.occlusion_strength = static_cast<float>(material.occlusion_strength);
    mesh.texture = textures.find_or_load(material.base_texture,
                                         material.alpha_mode == AlphaMode::opaque
                                             ? TextureUse::colours
                                             : TextureUse::colours_with_alpha,
                                         warnings);
    mesh.emissive_texture =
        textures.find_or_load(material.emissive_texture, TextureUse::colours, warnings);
    const auto load_numbers = [&](int texture) {
        return textures.find_or_load(texture, TextureUse::numbers, warnings);
    };
    finish.metallic_roughness_texture = load_numbers(material.metallic_roughness_texture);
    finish.normal_texture = load_numbers(material.normal_texture);
    finish.occlusion_texture = load_numbers(material.occlusion_texture);
    const std::array all{&mesh.texture, &mesh.emissive_texture, &finish.metallic_roughness_texture,
                         &finish.normal_texture, &finish.occlusion_texture};
    if (primitive.geometry->texture_coordinate.empty() &&
        std::ranges::any_of(all, [](const int *texture) { return *texture >= 0; })) {
        for (int *const texture : all) {
            *texture = -1;
        }
        warnings.add_of(node.label, &node,
                        "it has a texture but no TEXCOORD_" + std::to_string(material.texture_set) +
                            "; it is drawn without the texture");
    }
    for (const std::string &warning : material.warnings) {
        warnings.add_of(node.label, &node, warning);
    }
    if (!has_emissive_texture || mesh.emissive_texture >= 0) {
        std::ranges::transform(material.emission, mesh.emission.begin(),
                               [](double part) { return static_cast<float>(part); });
    }
}

Vector3 centre_of(const VisualMesh &mesh) {
    Vector3 sum_m = Vector3::Zero();
    for (const VisualVertex &vertex : mesh.vertices) {
        sum_m += Vector3(vertex.position_m[0], vertex.position_m[1], vertex.position_m[2]);
    }
    return sum_m / std::max(1.0, static_cast<double>(mesh.vertices.size()));
}

} // namespace

Matrix3 normal_matrix(const Matrix3 &M, bool mirrors) {
    Matrix3 cofactors;
    for (int row = 0; row < 3; ++row) {
        cofactors.row(row) = M.row((row + 1) % 3).cross(M.row((row + 2) % 3));
    }
    return mirrors ? Matrix3(-cofactors) : cofactors;
}

std::vector<Triangle> assemble_triangles(int mode, const std::vector<std::uint32_t> &corners) {
    std::vector<Triangle> triangles;
    if (corners.size() < 3) {
        return triangles;
    }
    if (mode == TINYGLTF_MODE_TRIANGLES) {
        triangles.reserve(corners.size() / 3);
        for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
            triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
        }
        return triangles;
    }
    triangles.reserve(corners.size() - 2);
    for (std::size_t i = 0; i + 2 < corners.size(); ++i) {
        if (mode == TINYGLTF_MODE_TRIANGLE_FAN) {
            triangles.push_back({corners[i + 1], corners[i + 2], corners[0]});
        } else { // a strip: every second triangle is turned over
            triangles.push_back({corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]});
        }
    }
    return triangles;
}

PrimitiveGeometry read_primitive(const tinygltf::Model &model, const tinygltf::Primitive &primitive,
                                 const DrawnMaterial &material) {
    PrimitiveGeometry geometry;
    if (primitive.mode < TINYGLTF_MODE_POINTS || primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN) {
        throw InputError("primitive mode " + std::to_string(primitive.mode) +
                         " is unknown; glTF has 0 to 6");
    }
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) {
        geometry.untouchable = "a primitive without POSITION"; // valid; other programs place it
        return geometry;
    }
    const int corners = primitive.indices >= 0 ? primitive.indices : position->second;
    note_untouchable(primitive.mode, accessor_count(model, corners), geometry);
    if (!geometry.untouchable.empty()) {
        return geometry;
    }

    const AttributeSource source(model, primitive);
    geometry.position = source.read("POSITION", Scaling::as_declared);
    const std::size_t count = geometry.position.count();
    check_shape(geometry.position, "POSITION", 3, 3, count);
    check_finite(geometry.position, "POSITION");
    read_triangles(model, primitive, source.draco(), geometry);
    check_in_range(geometry.triangles, count);

    stop_if_given_up();
    const std::string set = "TEXCOORD_" + std::to_string(material.texture_set);
    geometry.normal = source.read("NORMAL", Scaling::unit_range);
    if (material.normal_texture >= 0 && !geometry.normal.empty()) { // else they count for nothing
        geometry.tangent = source.read("TANGENT", Scaling::unit_range);
    }
    geometry.colour = source.read("COLOR_0", Scaling::unit_range);
    geometry.texture_coordinate = source.read(set, Scaling::as_declared);
    check_shape(geometry.normal, "NORMAL", 3, 3, count);
    check_shape(geometry.tangent, "TANGENT", 4, 4, count);
    check_shape(geometry.colour, "COLOR_0", 3, 4, count);
    check_shape(geometry.texture_coordinate, set, 2, 2, count);
    check_finite(geometry.tangent, "TANGENT");
    check_finite(geometry.colour, "COLOR_0");
    check_finite(geometry.texture_coordinate, set);
    while (!model.skins.empty()) {
        const std::string n = std::to_string(geometry.joint_sets.size());
        JointSet joints{source.read("JOINTS_" + n, Scaling::as_declared),
                        source.read("WEIGHTS_" + n, Scaling::unit_range)};
        if (joints.joints.empty() != joints.weights.empty()) {
            throw InputError("JOINTS_" + n + " and WEIGHTS_" + n + " need each other");
        }
        if (joints.joints.empty()) {
            break;
        }
        check_shape(joints.joints, "JOINTS_" + n, 4, 4, count);
        check_shape(joints.weights, "WEIGHTS_" + n, 4, 4, count);
        check_finite(joints.weights, "WEIGHTS_" + n);
        geometry.joint_sets.push_back(std::move(joints));
    }
    return geometry;
}

std::size_t first_node_size(std::span<const PlacedPrimitive> primitives) {
    const auto last = std::ranges::find_if(primitives, [&](const PlacedPrimitive &primitive) {
        return primitive.node != primitives.front().node;
    });
    return static_cast<std::size_t>(last - primitives.begin());
}

Vector3 world_normal(const PlacedPrimitive &primitive, std::size_t vertex) {
    if (!primitive.normals.empty()) {
        SPRINGDRIVE_ASSERT(vertex < primitive.normals.size());
        return primitive.normals[vertex];
    }
    SPRINGDRIVE_ASSERT(vertex < primitive.geometry->normal.count());
    return normal_matrix(primitive.node->to_world.linear(), mirrors(*primitive.node)) *
           Vector3(primitive.geometry->normal[vertex].data());
}

void add_surface(const PlacedPrimitive &primitive, std::uint16_t material,
                 contact::TriangleSoup &surface) {
    const auto first = static_cast<std::uint32_t>(surface.vertices_m.size());
    surface.vertices_m.insert(surface.vertices_m.end(), primitive.positions.begin(),
                              primitive.positions.end());
    const bool mirrored = mirrors(*primitive.node);
    for (const Triangle &local : primitive.geometry->triangles) {
        const Triangle triangle = wound_outwards(local, mirrored);
        stop_if_given_up(surface.triangles.size());
        surface.triangles.push_back(
            {first + triangle[0], first + triangle[1], first + triangle[2]});
        surface.material_of_triangle.push_back(material);
    }
}

std::vector<VisualMesh> visual_meshes(const PlacedPrimitive &primitive, TextureLibrary &textures,
                                      WarningList &warnings) {
    VisualMesh mesh;
    mesh.name = primitive.node->name;
    mesh.double_sided = primitive.material.double_sided;
    add_material(primitive, textures, warnings, mesh);
    if (primitive.geometry->normal.empty() && primitive.normals.empty()) {
        add_flat(primitive, mesh);
    } else {
        add_smooth(primitive, mesh);
    }
    std::vector<VisualMesh> pieces = in_pieces(std::move(mesh));
    for (VisualMesh &piece : pieces) {
        const bool shows_through =
            (piece.texture >= 0 && textures.has_alpha(piece.texture)) || has_alpha(piece);
        piece.translucent = shows_through && primitive.material.alpha_mode == AlphaMode::blend;
        if (primitive.material.alpha_mode == AlphaMode::mask &&
            (shows_through || primitive.material.alpha_cutoff > 1.0)) {
            piece.alpha_cutoff = static_cast<float>(primitive.material.alpha_cutoff);
        }
        piece.centre_m = centre_of(piece);
    }
    return pieces;
}

namespace {

constexpr std::size_t kMaxCuts = 128; // of an edge; more is asked for by damaged normals only

/// The primitives of one smooth node and their patches.
struct SmoothNode {
    std::span<PlacedPrimitive> primitives;
    CurvedPatches patches;
    std::size_t triangles;
    std::size_t wanted_cuts;
    std::size_t cuts;
};

/// All primitives as one mesh, in world coordinates.
SmoothMesh joined(std::span<const PlacedPrimitive> primitives) {
    SmoothMesh mesh;
    for (const PlacedPrimitive &primitive : primitives) {
        const std::string &label = primitive.node->label;
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (std::size_t i = 0; i < primitive.positions.size(); ++i) {
            mesh.positions.push_back(primitive.positions[i]);
            mesh.normals.push_back(world_normal(primitive, i).stableNormalized());
            if (!(std::abs(mesh.normals.back().norm() - 1.0) < 0.5)) {
                throw InputError(label + ": extras.smooth needs normals, but that of vertex " +
                                 std::to_string(i) + " has no direction; export it again");
            }
        }
        for (const auto &[a, b, c] : primitive.geometry->triangles) {
            mesh.triangles.push_back({first + a, first + b, first + c});
        }
    }
    return mesh;
}

/// A vertex attribute at the vertices of the divided patches.
Attribute interpolated(const Attribute &coarse, const std::vector<Triangle> &triangles,
                       std::size_t cuts) {
    Attribute fine{coarse.components, {}};
    if (coarse.empty()) {
        return fine;
    }
    for (const Triangle &triangle : triangles) {
        for_each_grid_point(cuts, [&](const std::array<std::size_t, 3> &weights) {
            for (std::size_t c = 0; c < static_cast<std::size_t>(coarse.components); ++c) {
                double sum = 0.0;
                for (std::size_t corner = 0; corner < 3; ++corner) {
                    sum += static_cast<double>(weights[corner]) * coarse[triangle[corner]][c];
                }
                fine.values.push_back(sum / static_cast<double>(cuts));
            }
        });
    }
    return fine;
}

/// @param first  index of the first patch of the primitive
void bend(PlacedPrimitive &primitive, const CurvedPatches &patches, std::size_t first,
          std::size_t cuts) {
    const PrimitiveGeometry &coarse = *primitive.geometry;
    SmoothMesh curved = patches.cut(cuts, first, first + coarse.triangles.size());
    PrimitiveGeometry fine;
    fine.colour = interpolated(coarse.colour, coarse.triangles, cuts);
    fine.texture_coordinate = interpolated(coarse.texture_coordinate, coarse.triangles, cuts);
    fine.triangles = std::move(curved.triangles);
    primitive.geometry = std::make_shared<const PrimitiveGeometry>(std::move(fine));
    primitive.positions = std::move(curved.positions);
    primitive.normals = std::move(curved.normals);
}

void bend(const SmoothNode &node) {
    std::size_t first = 0;
    for (PlacedPrimitive &primitive : node.primitives) {
        const std::size_t count = primitive.geometry->triangles.size();
        bend(primitive, node.patches, first, node.cuts);
        first += count;
    }
}

std::size_t triangles_of(std::span<const PlacedPrimitive> primitives) {
    std::size_t triangles = 0;
    for (const PlacedPrimitive &primitive : primitives) {
        triangles += primitive.geometry->triangles.size();
    }
    return triangles;
}

bool have_normals(std::span<const PlacedPrimitive> primitives) {
    return std::ranges::none_of(primitives, [](const PlacedPrimitive &primitive) {
        return primitive.geometry->normal.empty();
    });
}

/// The smooth primitives, except those without normals and those with too many triangles to be
/// divided even once.
std::vector<SmoothNode> find_smooth_nodes(std::vector<PlacedPrimitive> &primitives,
                                          WarningList &warnings) {
    std::vector<SmoothNode> nodes;
    for (std::span rest(primitives); !rest.empty();) {
        const std::span those = rest.first(first_node_size(rest));
        rest = rest.subspan(those.size());
        const PlacedMesh *const node = those.front().node;
        const std::size_t triangles = triangles_of(those);
        if (!node->touch.smooth) {
            continue;
        }
        if (4 * triangles > kMaxCurvedTriangles) {
            warnings.add_of(node->label, node,
                            "is too large to be smoothed further; its " +
                                std::to_string(triangles) + " triangles stay flat");
            continue;
        }
        if (!have_normals(those)) {
            warnings.add_of(node->label, node,
                            "extras.smooth is left out: it needs normals; export it with them");
            continue;
        }
        CurvedPatches patches(joined(those));
        const std::size_t cuts = patches.cuts_for(kSmooth_deg / kDegreesPerRadian, kMaxCuts);
        nodes.push_back({those, std::move(patches), triangles, cuts, cuts});
    }
    return nodes;
}

/// Coarser division of all, where there would be too many triangles.
void keep_within_allowance(std::vector<SmoothNode> &nodes) {
    double requested = 0.0;
    for (const SmoothNode &node : nodes) {
        requested += static_cast<double>(node.triangles * node.cuts * node.cuts);
    }
    const double share = std::sqrt(static_cast<double>(kMaxCurvedTriangles) / requested);
    for (SmoothNode &node : nodes) {
        const double cuts = std::floor(share * static_cast<double>(node.cuts));
        node.cuts = std::clamp<std::size_t>(static_cast<std::size_t>(cuts), 1, node.cuts);
    }
}

void warn_about(const SmoothNode &node, WarningList &warnings) {
    if (node.cuts == node.wanted_cuts && node.cuts < kMaxCuts) {
        return; // as smooth as it should be
    }
    const double turn_deg =
        node.patches.max_turn_rad(std::max<std::size_t>(node.cuts, 2)) * kDegreesPerRadian;
    const double reached_deg = node.cuts == 1 ? 2.0 * turn_deg : turn_deg;
    if (reached_deg > kSmooth_deg) {
        const PlacedMesh *const place = node.primitives.front().node;
        warnings.add_of(place->label, place,
                        "its " + std::to_string(node.triangles * node.cuts * node.cuts) +
                            " curved facets still differ by up to " +
                            shortest_text(std::round(100.0 * reached_deg) / 100.0) +
                            " degrees from their neighbours, instead of " +
                            shortest_text(kSmooth_deg));
    }
}

} // namespace

void bend_smooth_nodes(std::vector<PlacedPrimitive> &primitives, WarningList &warnings) {
    std::vector<SmoothNode> nodes = find_smooth_nodes(primitives, warnings);
    keep_within_allowance(nodes);
    for (const SmoothNode &node : nodes) {
        warn_about(node, warnings);
        if (node.cuts > 1) {
            bend(node);
        }
    }
}

} // namespace springdrive::scene::gltf
