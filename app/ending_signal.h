// A signal that asks the program to end (SIGINT, SIGTERM, SIGHUP) is only noted: who runs a loop
// looks.
#pragma once

namespace springdrive::app {

/// From now on such signals are noted.
void note_ending_signals();

[[nodiscard]] bool asked_to_end();

} // namespace springdrive::app
