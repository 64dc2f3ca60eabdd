// What is behind a gadget's endpoints: an emulated board, or, to measure the link alone, an echo.
#pragma once

#include "device/usb/protocol.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace springdrive::emulator {

/// For one thread at a time.
class Peripheral {
public:
    Peripheral() = default;
    Peripheral(const Peripheral &) = delete;
    Peripheral &operator=(const Peripheral &) = delete;
    virtual ~Peripheral() = default;

    /// A packet from the OUT endpoint.
    virtual void put(std::span<const std::uint8_t> packet) = 0;

    /// The next packet for the IN endpoint, if there is one now.
    /// @return its size; 0: none
    virtual std::size_t take(usb::Frame &packet) = 0;

    /// A control request with data from the host. @return false: to be stalled
    virtual bool control_out(std::uint8_t request, std::uint16_t value,
                             std::span<const std::uint8_t> payload) = 0;

    /// A control request for data.
    /// @param payload  of at least board::kMaxPayload bytes
    /// @return how many of them to send; 0: to be stalled
    virtual std::size_t control_in(std::uint8_t request, std::uint16_t value,
                                   std::span<std::uint8_t> payload) = 0;

    /// The host has configured the device.
    virtual void attach(bool is_high_speed) = 0;
    /// Bus reset, suspend, or the cable pulled.
    virtual void detach() = 0;

    /// Time passes by the wall clock, as long as since the last call; called at least every few
    /// milliseconds. @return how long until it wants to be called again, at most [s]
    virtual double pass(double elapsed_s) = 0;
};

} // namespace springdrive::emulator
