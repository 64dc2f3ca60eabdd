// A board on USB, by libusb-1.0.
//
//   servo ──Latest──► ┌────────┐ ──2 transfers OUT──► board
//   servo ◄──ring──── │ thread │ ◄─4 transfers IN──── board
//                     └────────┘
//
// libusb locks and allocates, so a thread of its own calls it. The servo's thread passes packets to
// and from that thread without waiting, and wakes it, or is woken, by an eventfd: one system call
// each. Of commands that could not leave yet, only the newest is kept.
#pragma once

#include "device/core/haptic_device.h"
#include "device/usb/driver/board_port.h"
#include "device/usb/driver/board_survey.h"

#include <memory>
#include <vector>

namespace springdrive::usb {

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

/// The priority that a port's thread requests: just above the servo's, which it serves.
inline constexpr int kPortThreadPriority = 81;

[[nodiscard]] std::unique_ptr<BoardPort> make_libusb_port();

} // namespace springdrive::usb
