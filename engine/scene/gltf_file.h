// A glTF file from disk to tinygltf's model, with the checks that tinygltf leaves out.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tinygltf {
class Model;
}

namespace springdrive::scene::gltf {

using Bytes = std::vector<unsigned char>;

/// @throw InputError, without the file's name, for what is no ordinary file, is empty, cannot be
///        read or is larger than 2 GB.
[[nodiscard]] Bytes read_bytes(const std::filesystem::path &file);

/// Reads a .gltf or .glb, told apart by their first bytes, with the buffers and images it refers
/// to. Images stay encoded: an image in a file of its own or in a data URI lies in `image`, one in
/// a buffer view only names the view. References between the model's arrays are not checked here.
/// @throw InputError, without the file's name, for a file that is missing, empty, truncated, no
///        glTF 2.0, or needs an extension that we lack.
[[nodiscard]] tinygltf::Model read_model(const std::filesystem::path &file);

/// What the file holds that we leave out without harm: extensions that it uses but can do
/// without, and animations.
[[nodiscard]] std::vector<std::string> left_out_of(const tinygltf::Model &model);

} // namespace springdrive::scene::gltf
