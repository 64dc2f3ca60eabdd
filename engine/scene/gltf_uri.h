// The bytes that a URI in a glTF stands for: in a file beside the scene, or in the URI itself.
// Messages of errors go on from the URI's name: "'wood.png' " + "cannot be read".
#pragma once

#include "engine/scene/gltf_file.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace springdrive::scene::gltf {

/// The bytes of a `data:` URI, in base64 or percent-encoded (RFC 2397).
/// @throw InputError with the position for a character that neither allows.
[[nodiscard]] Bytes decode_data_uri(std::string_view uri);

/// Each "%20" as the byte that it stands for; a '%' that no two hexadecimal digits follow remains.
[[nodiscard]] std::string percent_decoded(std::string_view text);

/// The file that a relative URI names. Nothing is opened; only symbolic links are resolved.
/// @param folder of the scene's file
/// @throw InputError for a URI that is not relative, and for a file that does not lie in `folder`
///        or a folder within it, also by way of symbolic links.
[[nodiscard]] std::filesystem::path file_of(std::string_view uri,
                                            const std::filesystem::path &folder);

/// @param max_bytes of a file with more, the first so many are read
/// @throw InputError for what cannot be read.
[[nodiscard]] Bytes read_uri(std::string_view uri, const std::filesystem::path &folder,
                             std::size_t max_bytes);

/// Whether the bytes are in the URI itself.
[[nodiscard]] bool is_data_uri(std::string_view uri);

/// For messages: "'wood.png'", or "its data: URI".
[[nodiscard]] std::string name_of_uri(std::string_view uri);

} // namespace springdrive::scene::gltf
