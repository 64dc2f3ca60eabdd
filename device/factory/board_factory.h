// Opens a board for its commissioning: one on USB, or an emulated one in this process.
#pragma once

#include "device/factory/device_factory.h"
#include "device/usb/emulator/emulated_board.h"

#include <memory>

namespace springdrive::factory {

struct BoardRequest {
    DeviceKind kind = DeviceKind::simulated;
    std::string serial;                    ///< of a board on USB; empty: the only one
    device::DeviceDescription description; ///< what its host takes it for
    double period_s = 1e-3;                ///< of its reports, which pace `read`
    /// Without a command, after which the board brakes by itself. A thread that drives nothing need
    /// not be a servo's: only a long silence then means that it ended.
    double watchdog_periods = 50.0;
    /// Whether calibrations do not matter, in the file or on the board, of whatever device: the
    /// description is then without one.
    bool ignores_calibration = false;

    // For an emulated board only.
    device::DeviceDescription truth; ///< what it is
    emulator::EmulatedBoardOptions emulation;
};

/// A board, with its `Bench`.
struct OpenBoard {
    std::unique_ptr<emulator::EmulatedBoard> emulated; ///< null for one on USB
    std::unique_ptr<device::HapticDevice> device;      ///< closes itself first
};

/// @throw InputError with one line, as `open_device` does
[[nodiscard]] OpenBoard open_board(const BoardRequest &request);

} // namespace springdrive::factory
