// Signals that request termination (SIGINT, SIGTERM, SIGHUP) only set a flag, which loops poll.
#pragma once

namespace springdrive::app {

/// Installs the handlers of these signals.
void note_ending_signals();

[[nodiscard]] bool asked_to_end();

} // namespace springdrive::app
