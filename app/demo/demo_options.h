// Options of the demo, as plain values.
#pragma once

#include "base/new_file.h"
#include "engine/session/session_options.h"

#include <filesystem>

namespace springdrive::app {

struct DemoOptions {
    session::SessionOptions session;
    int frames = 0;               ///< end after this many; 0: no limit
    double seconds = 0.0;         ///< end after this time (in lockstep: frame time); 0: no limit
    std::filesystem::path opened; ///< a record or the folder of a run; empty: none
    std::filesystem::path screenshot;   ///< empty: none
    Existing existing = Existing::keep; ///< of the screenshot
    int width = 0; ///< of the window in pixels; 0: 1280 × 720 times the display's scale
    int height = 0;
    double scale = 0.0;             ///< of text and panels; 0: the display's own
    bool assistant = false;         ///< opens it, whatever the device has come through
    std::filesystem::path settings; ///< of the window, to be remembered; empty: they are not
    bool kiosk = false;             ///< an exhibit, see app/exhibit/kiosk.h
    std::filesystem::path day_log;  ///< of a kiosk; empty: none
    bool reports = false;           ///< answers requests on standard input, see ReportRequests
    bool unseen = false;            ///< see Window::Wish

    /// A run that ends by itself follows a path, so that it touches something.
    [[nodiscard]] bool unattended() const { return frames > 0 || seconds > 0.0; }

    /// A run whose frames are drawn as requests ask for them, with the time of frames.
    [[nodiscard]] bool is_stepped() const { return session.lockstep && reports && !unattended(); }
};

} // namespace springdrive::app
