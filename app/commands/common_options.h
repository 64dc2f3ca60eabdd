// Options that several subcommands share.
#pragma once

#include "device/simulated/simulation_options.h"
#include "engine/control/parameters.h"
#include "engine/control/tuning.h"

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace springdrive {

/// `--device-file`: `file` starts as the PHANTOM 1.0.
void add_device_file_option(CLI::App &command, std::filesystem::path &file);

/// `--tuning-file`, and an option for each parameter that is given on top of it.
struct TuningOptions {
    std::filesystem::path file; ///< empty: the default tuning
    std::array<std::optional<double>, kParameters.size()> value;
    std::string map;        ///< empty: as in the file
    std::string alpha_mode; ///< empty: as in the file

    /// The options hold references to this: it must stay where it is until the parse is over.
    void add_to(CLI::App &command);

    /// @throw InputError for a file that cannot be used, or a value out of its range.
    [[nodiscard]] Tuning tuning() const;
};

/// `--without` and `--with`: which effects the simulated device has.
struct EffectOptions {
    std::vector<std::string> without;
    std::vector<std::string> with;

    /// The options hold references to this: it must stay where it is until the parse is over.
    void add_to(CLI::App &command);

    [[nodiscard]] PlantEffects effects() const;
};

} // namespace springdrive
