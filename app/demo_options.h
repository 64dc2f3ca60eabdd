// What the demo was asked to do, as plain values.
#pragma once

#include "engine/session/session_options.h"

#include <filesystem>

namespace springdrive::app {

struct DemoOptions {
    session::SessionOptions session;
    int frames = 0; ///< end after so many; 0: no end by frames
    double seconds =
        0.0; ///< end after so long, by frame time in lockstep, else by the clock; 0: no
    std::filesystem::path screenshot; ///< empty: none
    int width = 0; ///< of the window in pixels; 0: 1280 × 720 times the display's scale
    int height = 0;
    double scale = 0.0; ///< of text and panels; 0: the display's own

    /// A run that ends by itself plays a path, so that it touches something.
    [[nodiscard]] bool unattended() const { return frames > 0 || seconds > 0.0; }
};

} // namespace springdrive::app
