// Of a session alone: what its files share.
#pragma once

#include "engine/session/session.h"

#include <cstdint>
#include <filesystem>
#include <string>

namespace springdrive::session {

struct Session::Prepared {
    DeviceChoice choice;
    std::string text; ///< of the device's file
    factory::DeviceRequest request;
    factory::OpenDevice device;
};

/// So that a record holds what the session ran on, whatever becomes of the file.
/// @throw InputError with the reason for what is no device file
[[nodiscard]] std::string text_of_device(const std::filesystem::path &file);

/// Between rows of a record: which scene it is from here on.
[[nodiscard]] std::string note_on_scene(std::uint32_t scene_id, const LoadedScene &scene);

} // namespace springdrive::session
