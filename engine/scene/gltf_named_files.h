// The files that a glTF file refers to.
#pragma once

#include <filesystem>
#include <vector>

namespace springdrive::scene::gltf {

/// Of the buffers and images that are files of their own; they are not opened. Nothing for a file
/// that is missing or no glTF.
[[nodiscard]] std::vector<std::filesystem::path>
files_named_in(const std::filesystem::path &scene) noexcept;

} // namespace springdrive::scene::gltf
