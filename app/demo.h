// The demo: a session, its window, and the frames between opening and closing it.
#pragma once

#include "app/demo_options.h"

namespace springdrive::app {

/// Runs until the window is closed, its frames are over, or SIGINT or SIGTERM arrives. False where
/// its record is not whole, or an unattended run was stopped by the safety monitor.
/// @throw InputError for what cannot be used, before the servo starts or, for files that cannot be
///        written, after it was stopped.
[[nodiscard]] bool run_demo(const DemoOptions &options);

} // namespace springdrive::app
