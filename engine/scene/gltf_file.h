// A glTF file from disk to tinygltf's model, with the checks that tinygltf leaves out.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tinygltf {
class Model;
}

namespace springdrive::scene::gltf {

using Bytes = std::vector<unsigned char>;

/// Reads a .gltf or .glb, told apart by their first bytes, with the buffers and images it refers
/// to. Images stay encoded: an image in a file of its own or in a data URI lies in `image`, one in
/// a buffer view only names the view. References between the model's arrays are not checked here.
/// @throw InputError, without the file's name, for a file that is missing, empty, truncated, no
///        glTF 2.0, or needs an extension that is not supported.
[[nodiscard]] tinygltf::Model read_model(const std::filesystem::path &file);

/// What is left out of the file without harm: extensions that it uses but does not require, and
/// animations.
[[nodiscard]] std::vector<std::string> left_out_of(const tinygltf::Model &model);

/// @throw InputError, without the file's name, for what is no ordinary file, is empty, cannot be
///        read or is larger than 2 GB.
[[nodiscard]] Bytes read_bytes(const std::filesystem::path &file);

/// How deeply brackets nest in a JSON text. tinygltf reads `extras` recursively, so a file of
/// nothing but `[[[[…` would exhaust the stack.
[[nodiscard]] std::size_t json_nesting_depth(std::string_view text);

/// Refuses byte offsets and strides that are no whole numbers from 0: tinygltf reads them as 0, so
/// that other bytes than those meant would be taken from a damaged file.
/// @throw InputError naming the accessor or buffer view.
void check_byte_offsets(std::string_view text);

/// The same glTF without two things that are valid but that tinygltf refuses, and that are not
/// needed: `indices` of Draco-compressed primitives, whose accessor has no buffer view since the
/// triangles are in the Draco data; and `skins`, whose `inverseBindMatrices` may be left out.
/// A text that is no JSON is returned unchanged: tinygltf reports what is wrong with it.
[[nodiscard]] std::string adapted_to_tinygltf(std::string_view text);

/// Parses a checked file; buffers and images that it names are read from `folder`. It stands in
/// gltf_parse.cpp, the only file that compiles tinygltf's code.
/// @throw InputError with what tinygltf finds wrong, on one line.
[[nodiscard]] tinygltf::Model parse(std::span<const unsigned char> bytes, bool is_binary,
                                    const std::filesystem::path &folder);

} // namespace springdrive::scene::gltf
