// Control requests to a board, with errors of one line.
#pragma once

#include "base/input_error.h"
#include "device/usb/driver/board_names.h"
#include "device/usb/driver/board_port.h"

#include <fmt/format.h>

#include <array>
#include <string>

namespace springdrive::usb {

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
