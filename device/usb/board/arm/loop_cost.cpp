// One loop while driving, between two marks at which device/usb/board/arm/build counts its
// instructions: with independent or coupled channels, and a slow loop, which comes every 16th.
#include "device/usb/board/arm/semihosting.h"
#include "tests/device/usb/core_checks.h"

using namespace springdrive;

extern "C" [[gnu::noinline]] void mark_start() { asm volatile(""); }
extern "C" [[gnu::noinline]] void mark_end() { asm volatile(""); }

namespace {

testing::CoreTrial trial;

void measure(int loops) {
    for (int i = 0; i < loops; ++i) {
        mark_start();
        trial.order = trial.core.tick(trial.samples);
        mark_end();
        trial.samples.time_us += 25;
    }
}

} // namespace

int main() {
    new (&trial) testing::CoreTrial(); // no constructors run at start-up
    trial.drive(COUPLED != 0);
    trial.host_sends = false;
    (void)trial.send();
    measure(64);
    return trial.state() == board::State::driving ? 0 : 1;
}
