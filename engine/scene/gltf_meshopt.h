// Buffer views compressed by EXT_meshopt_compression, decoded with meshoptimizer.
#pragma once

namespace tinygltf {
class Model;
}

namespace springdrive::scene::gltf {

inline constexpr const char *kMeshoptExtension = "EXT_meshopt_compression";

/// Decodes every compressed buffer view into a buffer of its own, to which the view then refers.
/// @throw InputError naming the buffer view, for what is damaged, does not lie within its buffer,
/// or
///        is too large.
void decode_meshopt_views(tinygltf::Model &model);

} // namespace springdrive::scene::gltf
