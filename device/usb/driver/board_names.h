// A board's states and texts in words.
#pragma once

#include "device/usb/protocol.h"

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

} // namespace springdrive::usb
