// Control requests to a board, with errors of one line, and its states and texts in words.
#pragma once

#include "base/input_error.h"
#include "device/usb/driver/board_port.h"
#include "device/usb/protocol.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>

namespace springdrive::usb {

[[nodiscard]] constexpr const char *description_of(FrameStatus status) {
    switch (status) {
    case FrameStatus::ok:
        return "no error";
    case FrameStatus::wrong_size:
        return "a wrong size";
    case FrameStatus::wrong_crc:
        return "a wrong checksum";
    case FrameStatus::wrong_version:
        return "another version of the protocol";
    case FrameStatus::wrong_kind:
        return "another kind than expected";
    case FrameStatus::unknown_value:
        return "a value that this version does not have";
    case FrameStatus::not_finite:
        return "a number that is not finite";
    case FrameStatus::out_of_range:
        return "a number out of range";
    case FrameStatus::beyond_limits:
        return "a number beyond the board's limits";
    case FrameStatus::coupled:
        return "coupled channels, which the board does not have";
    case FrameStatus::repeated:
        return "the number of the one before";
    case FrameStatus::stale:
        return "a number of the past";
    }
    return "an unknown error";
}

[[nodiscard]] constexpr const char *description_of(BoardState state) {
    switch (state) {
    case BoardState::starting:
        return "starting";
    case BoardState::braking:
        return "braking";
    case BoardState::driving:
        return "driving";
    case BoardState::opened:
        return "windings open";
    case BoardState::testing:
        return "testing itself";
    case BoardState::fault_braking:
        return "fault, braking";
    case BoardState::fault_open:
        return "fault, windings open";
    }
    return "unknown";
}

/// Of an identity: up to the padding.
template <std::size_t size> [[nodiscard]] std::string text_of(const std::array<char, size> &text) {
    const auto end = std::find(text.begin(), text.end(), '\0');
    return {text.begin(), end};
}

/// @param board  its name in an error
/// @param what   that is asked for, the same
/// @throw InputError if the board is not connected, does not know the request, or answers nonsense
template <class Value>
[[nodiscard]] Value ask(BoardPort &port, Kind request, std::uint16_t index,
                        const std::string &board, const std::string &what) {
    std::array<std::uint8_t, detail::Layout<Value>::kSize> answer{};
    const std::size_t size = port.control_in(request, index, answer);
    Value value;
    if (const FrameStatus status = decode(answer.data(), size, value); status != FrameStatus::ok) {
        throw InputError(fmt::format("{}: cannot be asked for its {}: {}; is it a board for "
                                     "springdrive?",
                                     board, what,
                                     size == 0 ? "it refuses" : description_of(status)));
    }
    return value;
}

} // namespace springdrive::usb
