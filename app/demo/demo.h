// The demo: a session and its window.
#pragma once

#include "app/demo/demo_options.h"

namespace springdrive::app {

/// Runs until the window is closed, the given number of frames or seconds is over, or SIGINT or
/// SIGTERM arrives; a kiosk's window cannot be closed.
/// @return the exit status: 1 if its record is incomplete, or the safety monitor stopped an
///         unattended run; exhibit::kStartAgain of a kiosk that is to be started again
/// @throw InputError for invalid input, before the servo starts, or for files that cannot be
///        written, after it was stopped.
[[nodiscard]] int run_demo(const DemoOptions &options);

} // namespace springdrive::app
