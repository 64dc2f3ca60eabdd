// One glTF primitive as triangles, in the mesh's own coordinates.
#pragma once

#include "engine/scene/gltf_accessor.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace tinygltf {
class Model;
struct Primitive;
} // namespace tinygltf

namespace springdrive::scene::gltf {

using Triangle = std::array<std::uint32_t, 3>;

struct PrimitiveGeometry {
    Attribute position;           ///< three numbers a vertex, all finite
    Attribute normal;             ///< as the file has them, not necessarily unit; may be empty
    Attribute colour;             ///< three or four numbers a vertex, linear; may be empty
    Attribute texture_coordinate; ///< of the set asked for; may be empty
    std::vector<Triangle> triangles;
    std::string untouchable;           ///< "120 line segments" where it is no triangles, else empty
    std::size_t leftover_vertices = 0; ///< that were too few for another triangle
    bool has_morph_targets = false;
};

/// @param texture_set n of TEXCOORD_n
/// @throw InputError naming the accessor or attribute, for what is missing, does not fit together,
///        is not finite or lies outside its buffer, and for indices out of range.
[[nodiscard]] PrimitiveGeometry
read_primitive(const tinygltf::Model &model, const tinygltf::Primitive &primitive, int texture_set);

/// The triangles of `corners`, read as a list, strip or fan (glTF modes 4, 5 and 6). All keep the
/// winding of the first.
[[nodiscard]] std::vector<Triangle> assemble_triangles(int mode,
                                                       const std::vector<std::uint32_t> &corners);

} // namespace springdrive::scene::gltf
