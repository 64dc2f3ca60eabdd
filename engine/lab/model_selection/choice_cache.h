// Remembers model choices in files, so that a scene is measured once on a machine.
#pragma once

#include "engine/lab/model_selection/scene_model.h"

#include <filesystem>
#include <optional>
#include <string>

namespace springdrive::model_selection {

/// Raised whenever the simulation, the proxy or the rule of choice changes what is measured: older
/// choices are then measured anew.
inline constexpr int kModelMeasureVersion = 1;

/// SHA-256, 64 hex digits, of all that a choice depends on: what of the scene is touched, its
/// tolerance, the device, the tuning, rate and delay, the program's version and
/// `kModelMeasureVersion`, and the processor.
/// @param device_text  of the device's file
[[nodiscard]] std::string model_choice_key(const ModelQuestion &question,
                                           const std::string &device_text,
                                           const std::string &program_version);

/// $XDG_CACHE_HOME/springdrive, or ~/.cache/springdrive; empty where neither is known.
[[nodiscard]] std::filesystem::path model_cache_folder();

/// What `write_model_choice` left under that key; nothing where there is nothing, or it is damaged.
[[nodiscard]] std::optional<ModelChoice> read_model_choice(const std::filesystem::path &folder,
                                                           const std::string &key);

/// All or nothing, whoever else writes it at the same time. False where that was not possible.
bool write_model_choice(const std::filesystem::path &folder, const std::string &key,
                        const ModelChoice &choice) noexcept;

} // namespace springdrive::model_selection
