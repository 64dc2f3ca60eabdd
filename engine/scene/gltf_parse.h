// The one door to tinygltf's code; everyone else only reads the structs of its model.
#pragma once

#include <filesystem>
#include <span>

namespace tinygltf {
class Model;
}

namespace springdrive::scene::gltf {

/// Parses a checked file; buffers and images that it names are read from `folder`.
/// @throw InputError with what tinygltf finds wrong, on one line.
[[nodiscard]] tinygltf::Model parse(std::span<const unsigned char> bytes, bool is_binary,
                                    const std::filesystem::path &folder);

} // namespace springdrive::scene::gltf
