// Values passed between the amplifiers' loop and the code that handles USB, on one processor.
//
// The loop's interrupt pre-empts the other code and runs to its end, so it always finds a complete
// value; the other code repeats a read that the loop interrupted. Not for two threads of a host,
// which call both sides from one thread.
#pragma once

#include "device/usb/board/settings.h"

#include <atomic>

namespace springdrive::board {

/// The newest of a sequence of values: one writer, one reader.
template <class Value> class Published {
public:
    void publish(const Value &value) {
        draft() = value;
        publish_draft();
    }

    /// To be filled in and published in place: holds the value before the newest.
    [[nodiscard]] Value &draft() {
        return slot_[(number_.load(std::memory_order_relaxed) + 1U) & 1U];
    }
    void publish_draft() {
        number_.store(number_.load(std::memory_order_relaxed) + 1U, std::memory_order_release);
    }

    /// For the loop, which `publish` cannot interrupt.
    [[nodiscard]] const Value &newest() const {
        return slot_[number_.load(std::memory_order_acquire) & 1U];
    }

    /// For the code that the loop can interrupt.
    [[nodiscard]] Value copy() const {
        for (;;) {
            const std::uint32_t before = number_.load(std::memory_order_acquire);
            const Value value = slot_[before & 1U];
            std::atomic_signal_fence(std::memory_order_acq_rel);
            if (number_.load(std::memory_order_acquire) == before) {
                return value;
            }
        }
    }

private:
    std::array<Value, 2> slot_{};
    std::atomic<std::uint32_t> number_{0};
};

/// From USB to the loop. Each request has a number, which changes with each new one.
struct Orders {
    std::uint32_t changes = 0; ///< of anything below
    std::uint32_t command_changes = 0;
    usb::Command command;
    std::uint32_t command_arrived_at_us = 0;
    std::uint32_t reset_changes = 0;
    std::uint32_t zeroing_changes = 0;
    usb::Zeroing zeroing;
    std::uint32_t self_test_changes = 0;
    usb::SelfTestOrder self_test;
    std::uint32_t disconnections = 0;
    std::uint32_t report_period_us = 1000;
    usb::BoardCalibration calibration;
    bool is_storing = false; ///< a block is to be stored, or is being: no motor may be driven
};

/// From the loop to USB. `report` lacks what only the USB side knows: last_rejection and
/// rejected_frames.
struct LoopStatus {
    std::uint32_t reports = 0; ///< how many were due
    usb::Report report;
    Triple largest_cancelled_Ohm{}; ///< at the windings' present temperatures
    usb::SelfTestResult self_test;
    std::uint32_t silences = 0;
    std::uint32_t late_loops = 0;
};

} // namespace springdrive::board
