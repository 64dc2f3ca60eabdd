// Model choices as JSON, and in files, so that a scene is measured only once on a machine.
#pragma once

#include "engine/lab/model_selection/choose.h"
#include "engine/session/model/model_selection.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace springdrive::model_selection {

/// For `springdrive inspect` and for the cache files: with names and units in the keys. An error
/// that is not finite becomes null.
[[nodiscard]] nlohmann::ordered_json json_of(const ModelSelection &choice);

/// @throw InputError for JSON that `json_of` would not have written.
[[nodiscard]] ModelSelection model_selection_of(const nlohmann::ordered_json &json);

/// Increased whenever the simulation, the proxy or the rule of choice changes the measurements:
/// older choices are then measured again.
inline constexpr int kModelMeasureVersion = 1;

/// SHA-256, 64 hex digits, of everything that a choice depends on: the scene's touchable geometry,
/// its tolerance, the device, the tuning, rate and delay, the program's version and
/// `kModelMeasureVersion`, and the processor.
/// @param device_text  the contents of the device's file
[[nodiscard]] std::string model_selection_key(const ModelQuestion &question,
                                              const std::string &device_text,
                                              const std::string &program_version);

/// $XDG_CACHE_HOME/springdrive, or ~/.cache/springdrive; empty where neither is known.
[[nodiscard]] std::filesystem::path model_cache_folder();

/// The choice that `write_model_selection` stored under that key; nothing if there is none or it is
/// damaged.
[[nodiscard]] std::optional<ModelSelection>
read_model_selection(const std::filesystem::path &folder, const std::string &key);

/// Reads choices from the cache, or else measures them by `choose_scene_model` and writes them.
[[nodiscard]] std::shared_ptr<const ModelChooser> cached_chooser();

/// Atomic, even with concurrent writers. False where writing failed.
bool write_model_selection(const std::filesystem::path &folder, const std::string &key,
                           const ModelSelection &choice) noexcept;

} // namespace springdrive::model_selection
