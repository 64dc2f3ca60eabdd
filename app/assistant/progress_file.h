// How far each device has come in the assistant, in a TOML file for each:
//
//   done = ["link"]
//   failed = ["identity"]
#pragma once

#include "app/assistant/step.h"

#include <bitset>
#include <filesystem>
#include <string>

namespace springdrive::app::assistant {

using StepSet = std::bitset<kSteps>;

struct Progress {
    StepSet done;
    StepSet failed; ///< at which the device must not be driven
    bool operator==(const Progress &other) const = default;
};

/// $XDG_STATE_HOME/springdrive/assistant, or ~/.local/state/springdrive/assistant; empty where
/// neither is known.
[[nodiscard]] std::filesystem::path progress_folder();

/// A file name for a device of this kind and serial number, whatever letters that has.
[[nodiscard]] std::string progress_name(const std::string &kind, const std::string &serial);

/// Nothing is done if there is no such file.
/// @throw InputError with file, line and what is wrong with it
[[nodiscard]] Progress read_progress(const std::filesystem::path &file);

/// Makes the folder, too. @throw InputError if it cannot be written
void write_progress(const std::filesystem::path &file, const Progress &progress);

} // namespace springdrive::app::assistant
