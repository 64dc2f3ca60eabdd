#include "app/host/ending_signal.h"

#include <csignal>

namespace springdrive::app {

namespace {

volatile std::sig_atomic_t asked = 0;

extern "C" void on_signal(int /*signal*/) { asked = 1; }

} // namespace

void note_ending_signals() {
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
    std::signal(SIGHUP, on_signal); // the terminal was closed
}

bool asked_to_end() { return asked != 0; }

} // namespace springdrive::app
