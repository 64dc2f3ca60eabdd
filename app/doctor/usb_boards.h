// The boards on USB, by what libusb and what the kernel say.
#pragma once

#include "app/doctor/machine.h"
#include "app/doctor/probe.h"

#include <optional>
#include <string>
#include <vector>

namespace springdrive::app::doctor {

struct Board : usb::SurveyedBoard {
    [[nodiscard]] std::string name() const; ///< its serial number, or where it is
    [[nodiscard]] std::string node() const; ///< /dev/bus/usb/001/005
    [[nodiscard]] std::string sysfs_folder() const { return "/sys/bus/usb/devices/" + sysfs_name; }
    /// The hubs between it and the computer, in sysfs: "1-2" before "1-2.3".
    [[nodiscard]] std::vector<std::string> hubs() const;
};

/// The line of setup/70-springdrive-usb.rules: of a device with a board's numbers and its
/// interface, for the person at the screen.
[[nodiscard]] std::string udev_rule();

/// Those that libusb found. If none, those that the kernel has: libusb sees no board without its
/// device node.
[[nodiscard]] std::vector<Board> boards_of(const Machine &machine, const UsbProbe &probe);

/// The devices that have a board's numbers, which are for tests, but not its interface.
[[nodiscard]] std::vector<std::string> others_with_its_numbers(const Machine &machine);

struct UsingProcess {
    std::int64_t id = 0;
    std::string name;
};

/// The process that has the board's node open, as far as this user may see.
[[nodiscard]] std::optional<UsingProcess> user_of(const Machine &machine, const Board &board);

} // namespace springdrive::app::doctor
