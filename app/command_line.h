// What was typed, as plain values.
#pragma once

#include "engine/control/tuning.h"

#include <filesystem>
#include <optional>

namespace springdrive {

struct DemoOptions {
    std::filesystem::path scene;
    std::filesystem::path device_file;
    Tuning tuning;
    double servo_hz = 1000.0;
    int delay_samples = 0;
    int frames = 0; ///< end after so many; 0: no end by frames
    double seconds =
        0.0; ///< end after so long, by frame time in lockstep, else by the clock; 0: no
    bool lockstep = false;
    std::filesystem::path screenshot; ///< empty: none
    std::filesystem::path telemetry;  ///< empty: none
    std::filesystem::path path;       ///< empty: the mouse, or the scripted touch
    int width = 0; ///< of the window in pixels; 0: 1280 × 720 times the display's scale
    int height = 0;
    double scale = 0.0; ///< of text and panels; 0: the display's own

    /// A run that ends by itself plays a path, so that it touches something.
    [[nodiscard]] bool unattended() const { return frames > 0 || seconds > 0.0; }
};

/// The folder of devices, tunings and scenes: $SPRINGDRIVE_ASSETS, or where the sources are.
[[nodiscard]] std::filesystem::path asset_folder();

/// Parses the command line. Nothing when all was said already (--help, --version): then, and on a
/// mistake in the options, `exit_status` says how to end; a mistake has been printed as one line.
/// @throw InputError for a file or value that parses but cannot be used.
[[nodiscard]] std::optional<DemoOptions> parse_command_line(int argc, char **argv,
                                                            int &exit_status);

} // namespace springdrive
