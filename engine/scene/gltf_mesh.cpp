#include "engine/scene/gltf_mesh.h"

#include "base/assertions.h"
#include "base/wanted.h"
#include "engine/scene/visual_pieces.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace springdrive::scene::gltf {

namespace {

/// A node that mirrors turns its triangles inside out, so they are wound the other way round.
bool mirrors(const PlacedMesh &node) { return node.to_world.linear().determinant() < 0.0; }

Triangle wound_outwards(const Triangle &triangle, bool mirrored) {
    return mirrored ? Triangle{triangle[0], triangle[2], triangle[1]} : triangle;
}

std::array<float, 3> to_floats(const Vector3 &vector) {
    return {static_cast<float>(vector.x()), static_cast<float>(vector.y()),
            static_cast<float>(vector.z())};
}

std::array<float, 3> unit_or_up(const Vector3 &vector) {
    const double length = vector.stableNorm();
    return length > 0.0 && std::isfinite(length) ? to_floats(vector / length)
                                                 : std::array<float, 3>{0.0F, 1.0F, 0.0F};
}

/// What takes normals of the mesh to normals of the world, also for a singular transform: the
/// matrix of cofactors, |M| M⁻ᵀ, with the sign of |M| taken out.
Matrix3 normal_matrix(const PlacedMesh &node) {
    const Matrix3 M = node.to_world.linear();
    Matrix3 cofactors;
    for (int row = 0; row < 3; ++row) {
        cofactors.row(row) = M.row((row + 1) % 3).cross(M.row((row + 2) % 3));
    }
    return mirrors(node) ? Matrix3(-cofactors) : cofactors;
}

VisualVertex visual_vertex(const PlacedPrimitive &primitive, std::size_t i) {
    const BaseColour &base = primitive.colour;
    VisualVertex vertex{to_floats(primitive.positions[i]), {0.0F, 1.0F, 0.0F}, {}, {}};
    const Attribute &colour = primitive.geometry->colour;
    for (std::size_t c = 0; c < 4; ++c) {
        const bool given = !colour.empty() && c < static_cast<std::size_t>(colour.components);
        vertex.colour[c] = static_cast<float>(base.factor[c] * (given ? colour[i][c] : 1.0));
    }
    if (base.alpha_mode == AlphaMode::opaque) {
        vertex.colour[3] = 1.0F;
    }
    if (!primitive.geometry->texture_coordinate.empty()) {
        const std::span<const double> uv = primitive.geometry->texture_coordinate[i];
        const std::array<double, 2> placed = base.transform(uv[0], uv[1]);
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
    }
    for (const Triangle &local : primitive.geometry->triangles) {
        const Triangle triangle = wound_outwards(local, mirrored);
        mesh.indices.insert(mesh.indices.end(), triangle.begin(), triangle.end());
    }
}

/// Without normals glTF wants flat ones: each triangle gets its own three vertices.
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

Vector3 centre_of(const VisualMesh &mesh) {
    Vector3 sum_m = Vector3::Zero();
    for (const VisualVertex &vertex : mesh.vertices) {
        sum_m += Vector3(vertex.position_m[0], vertex.position_m[1], vertex.position_m[2]);
    }
    return sum_m / std::max(1.0, static_cast<double>(mesh.vertices.size()));
}

} // namespace

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
    return normal_matrix(*primitive.node) * Vector3(primitive.geometry->normal[vertex].data());
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
                                      std::vector<std::string> &remarks) {
    VisualMesh mesh;
    mesh.name = primitive.node->name;
    mesh.double_sided = primitive.colour.double_sided;
    mesh.texture = textures.find_or_load(primitive.colour, remarks);
    if (mesh.texture >= 0 && primitive.geometry->texture_coordinate.empty()) {
        mesh.texture = -1;
        remarks.push_back(primitive.node->label + ": it has a texture but no TEXCOORD_" +
                          std::to_string(primitive.colour.texture_set) +
                          "; it is drawn without the texture");
    }
    if (primitive.geometry->normal.empty() && primitive.normals.empty()) {
        add_flat(primitive, mesh);
    } else {
        add_smooth(primitive, mesh);
    }
    std::vector<VisualMesh> pieces = in_pieces(std::move(mesh));
    for (VisualMesh &piece : pieces) {
        piece.translucent =
            (piece.texture >= 0 && textures.has_alpha(piece.texture)) || has_alpha(piece);
        piece.centre_m = centre_of(piece);
    }
    return pieces;
}

} // namespace springdrive::scene::gltf
