// Which versions and extensions of glTF can be read, and which can be left out.
#pragma once

#include "engine/scene/warning_list.h"

#include <nlohmann/json_fwd.hpp>

namespace springdrive::scene::gltf {

/// @param document whose members have been checked
/// @throw InputError for another version than 2.x or a minimum version above 2.0, for a required
///        extension that is not supported, and for a material that has nothing but one.
void check_versions_and_extensions(const nlohmann::json &document);

/// On what is left out of the file without harm: extensions that it uses but does not require, and
/// animations.
void warn_about_left_out(const nlohmann::json &document, WarningList &warnings);

} // namespace springdrive::scene::gltf
