// Internal to Session: declarations shared by its source files.
#pragma once

#include "engine/session/session.h"

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <filesystem>
#include <string>

namespace springdrive::session {

struct Session::Prepared {
    DeviceChoice choice;
    std::string text; ///< of the device file
    factory::DeviceRequest request;
    factory::OpenDevice device;
};

/// The device file's text, so that a record is independent of the file.
/// @throw InputError with the reason if it is not a valid device file
[[nodiscard]] std::string text_of_device(const std::filesystem::path &file);

/// JSON text of one line; letters that are not UTF-8 are replaced.
[[nodiscard]] std::string dump(const nlohmann::json &json);

/// A note for a record: the scene from here on.
[[nodiscard]] std::string note_on_scene(std::uint32_t scene_id, const LoadedScene &scene);

} // namespace springdrive::session
