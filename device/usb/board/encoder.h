// Extends the 16-bit counter of an encoder to 32 bits.
#pragma once

#include <cstdint>

namespace springdrive::board {

class Encoder {
public:
    /// Counts since the last update; the first one counts from zero.
    /// @return false for a step larger than `largest_step`, either way: no motor turns so fast. The
    ///         counts follow it, but may be wrong by multiples of 2^16.
    [[nodiscard]] bool update(std::uint16_t counter, std::int32_t largest_step) {
        const auto step = static_cast<std::int16_t>(
            static_cast<std::uint16_t>(has_counter_ ? counter - counter_ : 0));
        counter_ = counter;
        has_counter_ = true;
        raw_counts_ += static_cast<std::uint32_t>(static_cast<std::int32_t>(step));
        return step >= -largest_step && step <= largest_step;
    }

    /// Counts as the host sees them, modulo 2^32.
    /// @param sign  1 or −1: direction of the encoder against its motor
    [[nodiscard]] std::int32_t counts(std::int8_t sign) const {
        return static_cast<std::int32_t>((sign < 0 ? 0U - raw_counts_ : raw_counts_) + offset_);
    }

    /// Declares the counts of the present angle.
    void declare(std::int32_t counts, std::int8_t sign) {
        offset_ = 0;
        offset_ =
            static_cast<std::uint32_t>(counts) - static_cast<std::uint32_t>(this->counts(sign));
    }

private:
    std::uint32_t raw_counts_ = 0; ///< modulo 2^32, as signed overflow is undefined
    std::uint32_t offset_ = 0;
    std::uint16_t counter_ = 0;
    bool has_counter_ = false;
};

} // namespace springdrive::board
