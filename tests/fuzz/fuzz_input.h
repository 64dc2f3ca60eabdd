// What the targets of the fuzzer share: an input as a sequence of decisions, and what has to hold.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
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

} // namespace springdrive::fuzz
