// A board on USB, by libusb-1.0.
//
//   servo ──Latest──► ┌────────┐ ──2 transfers OUT──► board
//   servo ◄──ring──── │ thread │ ◄─4 transfers IN──── board
//                     └────────┘
//
// libusb locks and allocates with each transfer, so a thread calls it whose heap is its own
// (base/real_time_thread.h). The servo's thread passes packets to and from that thread without
// waiting, and wakes it, or is woken, by an eventfd: one system call each. Of commands that could
// not leave yet, only the newest is kept.
#pragma once

#include "device/usb/driver/board_port.h"

#include <memory>

namespace springdrive::usb {

/// The priority that a port's thread requests: just above the servo's, which it serves.
inline constexpr int kPortThreadPriority = 81;

[[nodiscard]] std::unique_ptr<BoardPort> make_libusb_port();

} // namespace springdrive::usb
