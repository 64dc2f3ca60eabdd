// What has to be known of, or changed in, a glTF's JSON text before tinygltf may see it.
#pragma once

#include <string>
#include <string_view>

namespace springdrive::scene::gltf {

/// How deeply brackets nest in a JSON text. tinygltf reads `extras` recursively, so a file of
/// nothing but `[[[[…` would exhaust the stack.
[[nodiscard]] std::size_t json_nesting_depth(std::string_view json);

/// Refuses byte offsets and strides that are no whole numbers from 0: tinygltf reads them as 0, so
/// that a damaged file would show other bytes than it means.
/// @throw InputError naming the accessor or buffer view.
void check_byte_offsets(std::string_view json);

/// The same glTF without two things that are valid but that tinygltf refuses, and we do not need:
/// `indices` of Draco-compressed primitives, whose accessor has no buffer view since the triangles
/// are in the Draco data; and `skins`, whose `inverseBindMatrices` may be left out.
/// A text that is no JSON comes back as it is, for tinygltf to say what is wrong with it.
[[nodiscard]] std::string without_what_tinygltf_refuses(std::string_view json);

} // namespace springdrive::scene::gltf
