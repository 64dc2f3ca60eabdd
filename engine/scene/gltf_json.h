// The JSON text of a glTF file, checked before tinygltf converts it: tinygltf ignores most values
// of a wrong type, and names neither the place nor the value of what it refuses. Also which
// versions and extensions of glTF can be read, and which can be left out.
#pragma once

#include "engine/scene/load_messages.h"

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <string_view>

namespace springdrive::scene::gltf {

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
/// @throw InputError for another version than 2.x or a minimum version above 2.0, for a required
///        extension that is not supported, and for a material that has nothing but one.
void check_versions_and_extensions(const nlohmann::json &document);

/// On what is left out of the file without harm: extensions that it uses but does not require, and
/// animations.
void warn_about_left_out(const nlohmann::json &document, WarningList &warnings);

} // namespace springdrive::scene::gltf
