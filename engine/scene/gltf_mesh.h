// From a glTF primitive to the triangles that are touched and drawn where a node places it.
#pragma once

#include "engine/scene/gltf_accessor.h"
#include "engine/scene/gltf_material.h"
#include "engine/scene/gltf_nodes.h"
#include "engine/scene/load_messages.h"
#include "engine/scene/scene.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tinygltf {
class Model;
struct Primitive;
} // namespace tinygltf

namespace springdrive::scene::gltf {

/// Which joints of a skin move each vertex, and how much: JOINTS_n and WEIGHTS_n.
struct JointSet {
    Attribute joints;
    Attribute weights;
};

/// A primitive as triangles, in the mesh's own coordinates.
struct PrimitiveGeometry {
    Attribute position;           ///< three numbers a vertex, all finite
    Attribute normal;             ///< as the file has them, not necessarily unit; may be empty
    Attribute tangent;            ///< four numbers a vertex; empty also where no texture needs it
    Attribute colour;             ///< three or four numbers a vertex, linear; may be empty
    Attribute texture_coordinate; ///< of the set asked for; may be empty
    std::vector<Triangle> triangles;
    std::string untouchable; ///< "line segments" where it is no triangles, else empty
    std::optional<std::size_t> untouchable_count{}; ///< how many of them
    std::size_t leftover_vertices = 0;              ///< that were too few for another triangle
    std::vector<JointSet> joint_sets{};             ///< of n from 0; none if the file has no skins
};

/// @throw InputError naming the accessor or attribute, for what is missing, does not fit together,
///        is not finite or lies outside its buffer, and for indices out of range.
[[nodiscard]] PrimitiveGeometry read_primitive(const tinygltf::Model &model,
                                               const tinygltf::Primitive &primitive,
                                               const DrawnMaterial &material);

/// What takes normals along with what the map `M` does to positions, also if it is singular: the
/// matrix of cofactors, |M| M⁻ᵀ, with the sign of |M| taken out.
/// @param mirrors  whether |M| is negative
[[nodiscard]] Matrix3 normal_matrix(const Matrix3 &M, bool mirrors);

/// `geometry` as `node` places it at rest (glTF 2.0, 3.7.2.2 and 3.7.3.3): with its morph targets
/// by their default weights, and moved into the world by the node's skin. `geometry` itself if it
/// has none of both. Weights of joints are divided by their sum. `warnings` gains what the file
/// leaves open.
/// @throw InputError naming the attribute, for what does not fit together or is not finite, for a
///        negative weight, and for a joint that the skin does not have.
[[nodiscard]] std::shared_ptr<const PrimitiveGeometry>
at_rest(const tinygltf::Model &model, const tinygltf::Primitive &primitive,
        const std::shared_ptr<const PrimitiveGeometry> &geometry, const PlacedMesh &node,
        WarningList &warnings);

/// The triangles of `corners`, read as a list, strip or fan (glTF modes 4, 5 and 6). All keep the
/// winding of the first.
[[nodiscard]] std::vector<Triangle> assemble_triangles(int mode,
                                                       const std::vector<std::uint32_t> &corners);

/// A primitive where a node places it. `positions` are world coordinates: the file's units first,
/// metres in the device's frame once fitted.
struct PlacedPrimitive {
    const PlacedMesh *node = nullptr;
    std::shared_ptr<const PrimitiveGeometry> geometry; ///< nodes that place one mesh share it
    DrawnMaterial material;
    BoundingBox box; ///< of what the file's triangles use, in the mesh's own coordinates
    std::vector<Vector3> positions;
    std::vector<Vector3> normals; ///< in the world; empty while those of `geometry` are valid
};

/// How many of `primitives` belong to the node of the first: those of a node are adjacent.
[[nodiscard]] std::size_t first_node_size(std::span<const PlacedPrimitive> primitives);

/// The direction of a vertex's normal in the world, of any length. @pre there are normals
[[nodiscard]] Vector3 world_normal(const PlacedPrimitive &primitive, std::size_t vertex);

/// Appends the primitive to what can be touched, made of `material`.
void add_surface(const PlacedPrimitive &primitive, std::uint16_t material,
                 contact::TriangleSoup &surface);

/// What is drawn of the primitive; a large one is split into pieces. `warnings` gains what is left
/// out.
[[nodiscard]] std::vector<VisualMesh>
visual_meshes(const PlacedPrimitive &primitive, TextureLibrary &textures, WarningList &warnings);

// Curving the nodes that are marked smooth to the surfaces that their normals describe.

/// The largest angle between neighbouring facets of a smooth node, too small to be felt.
inline constexpr double kSmooth_deg = 0.5;

/// The maximum number of triangles of all smooth nodes of a scene together.
inline constexpr std::size_t kMaxCurvedTriangles = 2'000'000;

/// Replaces the primitives of smooth nodes by curved, finely divided ones; all primitives of a node
/// are divided alike, so that they stay joined. If this would exceed `kMaxCurvedTriangles`, all are
/// divided more coarsely, and `warnings` states the resulting angle between neighbouring facets.
/// Nodes without normals stay as they are, with a warning.
/// @throw InputError naming the node if a smooth one has normals of length zero.
void bend_smooth_nodes(std::vector<PlacedPrimitive> &primitives, WarningList &warnings);

} // namespace springdrive::scene::gltf
