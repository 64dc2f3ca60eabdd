// An emulated board as a USB device of this machine, in a process of its own.
#pragma once

#include "device/usb/emulator/emulated_board.h"

#include <string>
#include <sys/types.h>

namespace springdrive::usb_test {

/// The device of both ends: phantom_1_0.toml, in the current folder.
[[nodiscard]] device::DeviceDescription described();

/// What its command line holds.
struct EmulatorWish {
    std::string serial = "EMU-1";
    emulator::BoardClock clock = emulator::BoardClock::frame;
    double delay_periods = 0.3;
    double loop_hz = 40'000.0;
    double hand_N_per_m = 300.0;
};

[[nodiscard]] emulator::EmulatedBoardOptions board_options(const EmulatorWish &wish);

class EmulatorProcess {
public:
    /// Plugged in when it returns. @throw std::runtime_error if it cannot be started
    explicit EmulatorProcess(const EmulatorWish &wish = {});
    ~EmulatorProcess(); ///< unplugged, and ended
    EmulatorProcess(const EmulatorProcess &) = delete;
    EmulatorProcess &operator=(const EmulatorProcess &) = delete;

    void unplug() const { order('u'); }
    void plug_in() const { order('p'); }
    void kill();

private:
    void order(char letter) const;
    [[nodiscard]] std::string answer() const;

    pid_t process_ = -1;
    int orders_ = -1;
    int answers_ = -1;
};

/// The whole of the process, if these are its arguments; for `main`.
/// @return its exit status, or −1 if they are not
int emulate_if_asked(int argc, char **argv);

} // namespace springdrive::usb_test
