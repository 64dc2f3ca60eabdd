// What a glTF node says about touch in its "extras".
#pragma once

#include "engine/contact/mesh/surface_material.h"

#include <cstdint>
#include <optional>
#include <string>

namespace springdrive::scene::gltf {

/// The exact shapes that a node's mesh may stand for.
enum class ShapeKind : std::uint8_t { plate, sphere, box, cylinder, capsule };

/// All but `shape` pass from a node to its children.
struct TouchExtras {
    contact::SurfaceMaterial material;
    bool smooth = false;            ///< touched and drawn as the curved surface of its normals
    std::optional<ShapeKind> shape; ///< touched as this instead of as its triangles
};

/// A node's touch. The keys are those that `load_gltf` documents. A node that gives one
/// coefficient of friction gives both: the other is the same.
/// @param json the text of its extras
/// @param parent what its parent passes on
/// @param label of the node, for messages
/// @throw InputError for values of a wrong type, out of range or unknown, for dynamic friction
///        above static, and for a shape that cannot be touched from the sides that it asks for.
[[nodiscard]] TouchExtras read_touch(const std::string &json, const TouchExtras &parent,
                                     const std::string &label);

/// "plate", "sphere", ...: as files spell it.
[[nodiscard]] std::string name_of(ShapeKind shape);

} // namespace springdrive::scene::gltf
