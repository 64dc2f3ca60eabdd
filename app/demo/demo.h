// The demo: a session and its window, and its options as plain values.
#pragma once

#include "base/new_file.h"
#include "engine/session/session.h"

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

/// Runs until the window is closed, the given number of frames or seconds is over, or SIGINT or
/// SIGTERM arrives; a kiosk's window cannot be closed.
/// @return the exit status: 1 if its record is incomplete, or the safety monitor stopped an
///         unattended run; exhibit::kStartAgain of a kiosk that is to be started again
/// @throw InputError for invalid input, before the servo starts, or for files that cannot be
///        written, after it was stopped.
[[nodiscard]] int run_demo(const DemoOptions &options);

} // namespace springdrive::app
