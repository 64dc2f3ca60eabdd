// Targets of the fuzzer for both ends of the wire protocol. Each takes any bytes, and throws
// whatever its subject throws unexpectedly, or a Violation. The fuzzer makes the inputs
// (tests/fuzz/run); tests/device/usb/protocol_test.cpp replays those in tests/fuzz/corpus.
#pragma once

#include "device/usb/protocol.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::fuzz {

/// An input broke what has to hold for all.
class Violation : public std::logic_error {
public:
    explicit Violation(const std::string &what) : std::logic_error(what) {}
};

inline void require(bool holds, const char *what) {
    if (!holds) {
        throw Violation(what);
    }
}

/// @param text  of an error, for people
inline void require_one_line(const std::string &text) {
    const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20; };
    if (text.empty() || std::ranges::any_of(text, is_control)) {
        throw Violation("a message that is not one line: " + text);
    }
}

/// Decisions, read from the front. After the end all of them are zero.
class FuzzInput {
public:
    explicit FuzzInput(std::span<const std::uint8_t> bytes) : rest_(bytes) {}

    [[nodiscard]] bool has_more() const { return !rest_.empty(); }

    std::uint8_t byte() {
        if (rest_.empty()) {
            return 0;
        }
        const std::uint8_t first = rest_.front();
        rest_ = rest_.subspan(1);
        return first;
    }
    std::int8_t signed_byte() { return static_cast<std::int8_t>(byte()); }
    std::uint16_t u16() {
        const unsigned low = byte();
        return static_cast<std::uint16_t>(low | (static_cast<unsigned>(byte()) << 8U));
    }
    std::uint32_t u32() {
        const std::uint32_t low = u16();
        return low | (static_cast<std::uint32_t>(u16()) << 16U);
    }
    /// Any float, also NaN and infinite.
    float any_float() { return std::bit_cast<float>(u32()); }

    /// As many bytes as are left, up to `count`; of their own on the heap, so that the sanitizer
    /// sees the first access beyond them.
    std::vector<std::uint8_t> bytes(std::size_t count) {
        const auto taken = rest_.first(std::min(count, rest_.size()));
        rest_ = rest_.subspan(taken.size());
        return {taken.begin(), taken.end()};
    }

private:
    std::span<const std::uint8_t> rest_;
};

/// Packets, requests, samples and time for a board's core.
void take_usb_commands(std::span<const std::uint8_t> input);
/// Packets for the driver's stream of reports.
void take_usb_reports(std::span<const std::uint8_t> input);
/// A whole board's answers to the driver, and what is done with the device.
void take_usb_answers(std::span<const std::uint8_t> input);
/// A fault of the emulated board as text.
void take_usb_fault(std::span<const std::uint8_t> input);

struct UsbTarget {
    std::string_view name;
    void (*take)(std::span<const std::uint8_t>);
};
inline constexpr std::array<UsbTarget, 4> kUsbTargets{{
    {"usb-commands", take_usb_commands},
    {"usb-reports", take_usb_reports},
    {"usb-answers", take_usb_answers},
    {"usb-fault", take_usb_fault},
}};

/// Makes bytes a frame or payload of this version and kind with the right checksum, so that the
/// fuzzer need not guess it.
inline void seal(std::span<std::uint8_t> bytes, usb::Kind kind) {
    constexpr std::size_t kChecksum = usb::detail::kEnvelopeEnd;
    if (bytes.size() < usb::detail::kEnvelopeStart + kChecksum) {
        return;
    }
    bytes[0] = usb::kProtocolVersion;
    bytes[1] = static_cast<std::uint8_t>(kind);
    std::uint32_t crc = usb::crc32(bytes.data(), bytes.size() - kChecksum);
    for (std::uint8_t &byte : bytes.last(kChecksum)) {
        byte = static_cast<std::uint8_t>(crc & 0xffU);
        crc >>= 8U;
    }
}

/// What is decoded has to be encoded to the same bytes; if these may be NaN, which has many forms,
/// and temperatures, which are limited, to bytes that keep their meaning.
template <class Value>
usb::FrameStatus decoded_and_encoded(std::span<const std::uint8_t> bytes, Value &value) {
    const usb::FrameStatus status = usb::decode(bytes.data(), bytes.size(), value);
    if (status != usb::FrameStatus::ok || bytes[0] != usb::kProtocolVersion) {
        return status;
    }
    const auto encoded = usb::encode(value);
    if (usb::detail::Layout<Value>::kMayBeNan) {
        Value again;
        require(usb::decode(encoded.data(), encoded.size(), again) == status &&
                    usb::encode(again) == encoded,
                "decoded, but not encoded again");
    } else {
        require(std::ranges::equal(encoded, bytes), "decoded, but encoded to other bytes");
    }
    return status;
}

} // namespace springdrive::fuzz
