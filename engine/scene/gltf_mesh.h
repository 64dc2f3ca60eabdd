// From a primitive where a node places it to the triangles that are touched and drawn.
#pragma once

#include "engine/scene/fit.h"
#include "engine/scene/gltf_material.h"
#include "engine/scene/gltf_nodes.h"
#include "engine/scene/gltf_primitive.h"
#include "engine/scene/scene.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace springdrive::scene::gltf {

/// A primitive where a node places it. `positions` are world coordinates: the file's units first,
/// metres in the device's frame once fitted.
struct PlacedPrimitive {
    const PlacedMesh *node = nullptr;
    std::shared_ptr<const PrimitiveGeometry> geometry; ///< nodes that place one mesh share it
    BaseColour colour;
    BoundingBox box; ///< of what the file's triangles use, in the mesh's own coordinates
    std::vector<Vector3> positions;
    std::vector<Vector3> normals; ///< in the world; empty while those of `geometry` hold
};

/// How many of `primitives` belong to the node of the first: those of a node stand together.
[[nodiscard]] std::size_t first_node_size(std::span<const PlacedPrimitive> primitives);

/// The direction of a vertex's normal in the world, of any length. @pre there are normals
[[nodiscard]] Vector3 world_normal(const PlacedPrimitive &primitive, std::size_t vertex);

/// Appends the primitive to what can be touched, made of `material`.
void add_surface(const PlacedPrimitive &primitive, std::uint16_t material,
                 contact::TriangleSoup &surface);

/// What is drawn of the primitive; a large one comes in pieces. `remarks` gains what has to be left
/// out.
[[nodiscard]] std::vector<VisualMesh> visual_meshes(const PlacedPrimitive &primitive,
                                                    TextureLibrary &textures,
                                                    std::vector<std::string> &remarks);

} // namespace springdrive::scene::gltf
