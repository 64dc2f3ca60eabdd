// What carries packets between the driver and one board: libusb, or, in tests, a board in process.
#pragma once

#include "device/usb/protocol.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace springdrive::usb {

/// A packet as it arrived: of any length and content.
struct Packet {
    Frame data{};
    std::size_t size = 0;
    double arrived_s = 0.0; ///< by the port's clock
};

class BoardPort {
public:
    BoardPort() = default;
    BoardPort(const BoardPort &) = delete;
    BoardPort &operator=(const BoardPort &) = delete;
    virtual ~BoardPort() = default;

    // For one thread, which may be real-time: nothing here allocates, locks, throws or waits, but
    // `receive` up to its deadline.

    /// Queues a packet for the OUT endpoint. @return whether it could be queued
    virtual bool send(const Frame &frame) noexcept = 0;

    /// The next packet from the IN endpoint, in the order of their arrival.
    /// @param deadline_s  by this port's clock; waits no longer, and not at all if it has passed
    /// @return whether there was one
    virtual bool receive(Packet &packet, double deadline_s) noexcept = 0;

    /// Whether packets can still arrive; once false, until `open`.
    [[nodiscard]] virtual bool is_connected() const noexcept = 0;

    /// The port's clock, which never goes back [s].
    [[nodiscard]] virtual double now_s() const noexcept = 0;

    // For one thread at a time, while no other one is inside the members above.

    /// A control request with bmRequestType kRequestIn.
    /// @return the size of the board's answer; 0: the board does not know the request
    /// @throw InputError if the board is not connected, or does not answer
    virtual std::size_t control_in(Kind request, std::uint16_t value,
                                   std::span<std::uint8_t> answer) = 0;

    /// A control request with bmRequestType kRequestOut.
    /// @return whether the board accepts it
    /// @throw InputError if the board is not connected, or does not answer
    virtual bool control_out(Kind request, std::uint16_t value,
                             std::span<const std::uint8_t> payload) = 0;

    /// May be called twice.
    virtual void close() noexcept = 0;

    /// Connects again to the board with this serial number, once closed.
    /// @throw InputError with one line that says why not, and what to do
    virtual void open(const std::string &serial) = 0;

    /// Of the connection, as the host sees it: "high speed (480 Mbit/s)".
    [[nodiscard]] virtual std::string_view speed() const = 0;

    /// What the system refused to the connection, with what to do; empty if nothing.
    [[nodiscard]] virtual std::string_view warning() const { return {}; }
};

/// The priority that a port's thread requests: just above the servo's, which it serves.
inline constexpr int kPortThreadPriority = 81;

/// A board on USB, by libusb-1.0.
[[nodiscard]] std::unique_ptr<BoardPort> make_libusb_port();

} // namespace springdrive::usb
