// The boards that are connected, and what stands in the way of each.
#pragma once

#include "device/usb/protocol.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace springdrive::usb {

enum class BoardObstacle : std::uint8_t {
    none,
    no_permission, ///< for its device node
    in_use,        ///< by another program
    no_answer,
    no_interface,  ///< that answers as a board: firmware of another kind
    wrong_version, ///< of the protocol
};

struct SurveyedBoard {
    int bus = 0;
    int address = 0;        ///< on the bus: its node is /dev/bus/usb/BUS/ADDRESS, three digits each
    std::string sysfs_name; ///< in /sys/bus/usb/devices, by its ports: "1-2.3"
    std::string serial;     ///< empty if it could not be asked
    std::string speed;      ///< of the connection, as the host sees it
    std::string firmware;   ///< its name and version; empty if it could not be asked
    BoardObstacle obstacle = BoardObstacle::none;
    std::string problem; ///< the obstacle in words, with what to do; empty if there is none
};

/// A board that is connected to this machine.
struct FoundBoard {
    std::string serial;  ///< empty if it could not be asked
    std::string problem; ///< why it cannot be used, with what to do; empty if it can
};

/// The boards that are connected now.
/// @throw InputError if libusb cannot be used at all
[[nodiscard]] std::vector<FoundBoard> boards_present();

/// Everything that can be said about each board, which claims them for a moment: tens of
/// milliseconds, seconds for one that does not answer.
/// @throw InputError if libusb cannot be used at all
[[nodiscard]] std::vector<SurveyedBoard> survey_boards();

/// The name by which sysfs knows the device at the end of these ports, the computer's first.
[[nodiscard]] std::string sysfs_name_of(int bus, std::span<const std::uint8_t> ports);

/// Takes a board's answer to Kind::identity: its firmware, or that it does not fit this program.
/// @param answer  empty: it refuses
void take_identity(std::span<const std::uint8_t> answer, SurveyedBoard &board);

} // namespace springdrive::usb
