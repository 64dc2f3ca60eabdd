// A glTF file and the files that it refers to, from disk to tinygltf's model, with the checks that
// tinygltf leaves out.
#pragma once

#include "engine/scene/load_messages.h"

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace tinygltf {
class Model;
}

namespace springdrive::scene::gltf {

using Bytes = std::vector<unsigned char>;

/// Reads a .gltf or .glb, told apart by their first bytes, with the buffers it refers to; images
/// remain in their files and data URIs. Animations and cameras are left out. References between the
/// model's arrays are not checked here.
/// @param warnings gains what is left out of the file without harm
/// @throw InputError, without the file's name, for a file that is missing, empty, truncated, no
///        glTF 2.0, or needs an extension that is not supported; for members of a wrong type; and
///        for a buffer that cannot be read, is too short or lies outside the file's folder.
[[nodiscard]] tinygltf::Model read_model(const std::filesystem::path &file, WarningList &warnings);

/// The folder in which `read_model` looks for buffers, and in which images are to be looked for.
[[nodiscard]] std::filesystem::path folder_of(const std::filesystem::path &file);

/// The files that a glTF file refers to: its buffers and images that are files of their own. They
/// are not opened. Nothing for a file that is missing or no glTF.
[[nodiscard]] std::vector<std::filesystem::path>
files_named_in(const std::filesystem::path &scene) noexcept;

/// @throw InputError, without the file's name, for what is no ordinary file, is empty, cannot be
///        read or is larger than 2 GB.
[[nodiscard]] Bytes read_bytes(const std::filesystem::path &file);

/// The first `max_bytes` bytes, or all.
/// @throw InputError as above.
[[nodiscard]] Bytes read_first_bytes(const std::filesystem::path &file, std::size_t max_bytes);

/// tinygltf's model of a JSON text that refers to no other file. It stands in gltf_parse.cpp, the
/// only file that compiles tinygltf's code.
/// @throw InputError with what tinygltf finds wrong, on one line.
[[nodiscard]] tinygltf::Model parse(const std::string &text);

// The bytes that a URI in a glTF stands for: in a file beside the scene, or in the URI itself.
// Messages of errors go on from the URI's name: "'wood.png' " + "cannot be read".

/// The bytes of a `data:` URI, in base64 or percent-encoded (RFC 2397).
/// @throw InputError with the position for a character that neither allows.
[[nodiscard]] Bytes decode_data_uri(std::string_view uri);

/// Each "%20" as the byte that it stands for; a '%' that no two hexadecimal digits follow remains.
[[nodiscard]] std::string percent_decoded(std::string_view text);

/// The file that a relative URI names; if there is none, the only one that it can mean: with '\\'
/// for '/', with ASCII letters of the other case, or really called "a%20b". No file is opened.
/// @param folder of the scene's file
/// @throw InputError for a URI that is not relative, and for a file that does not lie in `folder`
///        or a folder within it, also by way of symbolic links. Where there is no file, with the
///        names of several that it can mean, or of one whose letters are composed otherwise.
[[nodiscard]] std::filesystem::path file_of(std::string_view uri,
                                            const std::filesystem::path &folder);

/// @param max_bytes of a file with more, the first so many are read
/// @param warnings gains the file's name if the URI spells it otherwise; may be null
/// @throw InputError for what cannot be read.
[[nodiscard]] Bytes read_uri(std::string_view uri, const std::filesystem::path &folder,
                             std::size_t max_bytes, WarningList *warnings = nullptr);

/// Whether two UTF-8 texts may differ only in that one has 'é' as one code point and the other as
/// two, a letter and its accent (Unicode's NFC and NFD).
[[nodiscard]] bool may_be_composed_otherwise(std::string_view a, std::string_view b);

/// Whether the bytes are in the URI itself.
[[nodiscard]] bool is_data_uri(std::string_view uri);

/// For messages: "'wood.png'", or "its data: URI".
[[nodiscard]] std::string name_of_uri(std::string_view uri);

// The JSON text of a glTF file, checked before tinygltf converts it: tinygltf ignores most values
// of a wrong type, and names neither the place nor the value of what it refuses. Also which
// versions and extensions of glTF can be read, and which can be left out.

/// How deeply brackets nest in a JSON text. tinygltf reads `extras` recursively, so a file of
/// nothing but `[[[[…` would exhaust the stack.
[[nodiscard]] std::size_t json_nesting_depth(std::string_view text);

/// @throw InputError with line and column for what is no JSON, with the place for a number that no
///        double can hold, for a text that nests deeper than 100 levels, and for what is no object.
[[nodiscard]] nlohmann::json parse_json(std::string_view text);

/// Checks the type of every member that the scene is made of; whole numbers that are written with a
/// fraction of zero become integers.
/// @throw InputError naming the place, the value and what it must be: for a member of a wrong type,
///        a whole number out of range, and a required member that is missing.
void check_members(nlohmann::json &document);

/// @param document whose members have been checked
/// @throw InputError for another version than 2.x or a minimum version above 2.0, and for a
/// required
///        extension that is not supported, unless it concerns only looks.
void check_versions_and_extensions(const nlohmann::json &document);

/// On what is left out of the file without harm: extensions that it uses but does not require, or
/// that concern only looks, and animations.
void warn_about_left_out(const nlohmann::json &document, WarningList &warnings);

} // namespace springdrive::scene::gltf
