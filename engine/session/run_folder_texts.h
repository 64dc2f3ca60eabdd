// The texts in the folder of a run: run.json, tuning_history.csv and events.csv.
#pragma once

#include "engine/session/run_folder.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::session {

/// The name of a device's file in the folder, by its number from 0: "device.toml",
/// "device-2.toml".
[[nodiscard]] std::filesystem::path name_of_device_file(std::size_t number);

/// All but what has a file of its own. @pre each record's device is one of `facts.devices`
/// @param folder  of the run: what is in it is named without its path
[[nodiscard]] std::string run_json(const RunFacts &facts, const std::filesystem::path &folder);

/// Fills times, scene, records and the number of devices from what `run_json` wrote.
/// @throw InputError, which names `file`, for a text that is not of its format
void read_run_json(std::string_view text, const std::filesystem::path &file, RunFacts &facts);

/// One line per event: times, name, and all parameters, named as in tuning files.
[[nodiscard]] std::string journal_csv(const std::vector<TuningEvent> &journal);

[[nodiscard]] std::string events_csv(const std::vector<RunEvent> &events);

} // namespace springdrive::session
