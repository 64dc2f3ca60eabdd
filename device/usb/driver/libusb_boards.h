// Boards by libusb-1.0: opens the one that is wanted, and says why another cannot be used. Within
// the driver.
#pragma once

#include <libusb-1.0/libusb.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace springdrive::usb {

inline constexpr unsigned kControlTimeout_ms = 500;

struct ContextEnd {
    void operator()(libusb_context *context) const { libusb_exit(context); }
};
using Context = std::unique_ptr<libusb_context, ContextEnd>;

struct HandleEnd {
    void operator()(libusb_device_handle *handle) const { libusb_close(handle); }
};
using Handle = std::unique_ptr<libusb_device_handle, HandleEnd>;

/// @throw InputError if libusb cannot be used
[[nodiscard]] Context make_context();

/// What to do about an error of libusb.
[[nodiscard]] std::string advice_on(int error);

[[nodiscard]] std::string_view name_of_speed(int speed);

/// The interface of the protocol, of any of its versions, and its endpoints.
struct Endpoints {
    int interface_number = 0;
    std::uint8_t protocol = 0;
    std::uint8_t in = 0;
    std::uint8_t out = 0;
};

/// A board that was opened; or why it was not.
struct OpenedBoard {
    std::string place;
    Endpoints endpoints;
    std::string serial;
    Handle handle;
    std::string problem;
};

/// The board with this serial number, or the only one.
/// @throw InputError with one line if there is none, or it cannot be opened
[[nodiscard]] OpenedBoard open_board_named(libusb_context *context, const std::string &serial);

} // namespace springdrive::usb
