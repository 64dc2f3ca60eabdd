// Tunings by name: those of the project and, in tests/tunings, the extremes that only tests use.
// *stable_only* are stable with the hands tried, with a margin of 1.3, but not passive.
#pragma once

#include "engine/control/tuning_file.h"
#include "tests/support/devices.h"

#include <filesystem>
#include <string>

namespace springdrive::testing {

inline std::filesystem::path tuning_path(const std::string &name) {
    const bool is_extreme = name.starts_with("stable_only");
    return (is_extreme ? assets() / "../tests/tunings" : assets() / "tunings") / (name + ".toml");
}

inline control::Tuning tuning(const std::string &name) {
    return control::read_tuning_file(tuning_path(name));
}

} // namespace springdrive::testing
