// From a primitive where a node places it to the triangles that are touched and drawn.
#pragma once

#include "engine/scene/gltf_material.h"
#include "engine/scene/gltf_nodes.h"
#include "engine/scene/gltf_primitive.h"
#include "engine/scene/scene.h"

#include <cstdint>
#include <string>
#include <vector>

namespace springdrive::gltf {

/// A primitive where a node places it. `positions` are world coordinates: the file's units first,
/// metres in the device's frame once fitted.
struct PlacedPrimitive {
    const PlacedMesh *node = nullptr;
    const PrimitiveGeometry *geometry = nullptr;
    const BaseColour *colour = nullptr;
    std::vector<Vector3> positions;
};

/// Appends the primitive to what can be touched, made of `material`.
void add_surface(const PlacedPrimitive &primitive, std::uint16_t material, TriangleSoup &surface);

/// What is drawn of the primitive. `remarks` gains what has to be left out.
[[nodiscard]] VisualMesh visual_mesh(const PlacedPrimitive &primitive, TextureLibrary &textures,
                                     std::vector<std::string> &remarks);

} // namespace springdrive::gltf
