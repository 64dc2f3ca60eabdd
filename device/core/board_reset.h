// Which commands may clear what a board has latched, while a device is tested or zeroed and no
// servo's safety monitor decides: never a stop that somebody wants, nor what no report showed.
#pragma once

#include "device/core/haptic_device.h"

#include <cstdint>

namespace springdrive::device {

class BoardReset {
public:
    /// @param clears_stop  also one that the first measurement shows, as of whoever begins this
    explicit BoardReset(bool clears_stop) : clears_stop_(clears_stop) {}

    /// To be asked with every measurement. @return whether the answer to it may reset faults
    [[nodiscard]] bool may_follow(const Measurement &measured) noexcept {
        const bool is_first = number_ == 0;
        if (!is_new(measured.arrival)) {
            has_gap_ = has_gap_ || !is_first;
            return false;
        }
        has_gap_ = has_gap_ || (!is_first && measured.number != number_ + 1);
        number_ = measured.number;
        const bool has_stop = measured.faults.has(BoardFaults::kStop);
        const bool is_pressed = measured.faults.has(BoardFaults::kPressed);
        const bool is_pressed_anew = !is_first && is_pressed && !was_pressed_;
        was_pressed_ = is_pressed;
        clears_stop_ = clears_stop_ && has_stop && !is_pressed_anew;
        has_stop_ = has_stop_ || ((has_stop || is_pressed) && !clears_stop_);
        return !has_gap_ && !has_stop_ && measured.faults.any();
    }

    /// Whether a stop was seen that stays.
    [[nodiscard]] bool has_stop() const noexcept { return has_stop_; }

private:
    bool clears_stop_;
    bool has_stop_ = false;
    bool has_gap_ = false;
    bool was_pressed_ = false;
    std::uint64_t number_ = 0; ///< of the last measurement; 0: none
};

} // namespace springdrive::device
