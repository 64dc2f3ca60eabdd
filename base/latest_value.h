// A mailbox for one writer thread and one reader thread that keeps only the newest value.
//
//   writer:  slots_[w] = value ──► exchange(shared, w) ──► w = what was shared before
//   reader:  if shared is fresh: exchange(shared, r)   ──► slots_[r] is the newest value
//
// Three slots, one atomic byte. Neither side ever waits, allocates or sees a partly written value.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace springdrive {

template <typename Value> class LatestValue {
public:
    explicit LatestValue(const Value &initial = Value{}) : slots_{initial, initial, initial} {}

    /// Replaces a value that the reader has not fetched yet. Writer thread only. RT-safe.
    void publish(const Value &value) noexcept {
        slots_[write_slot_] = value;
        const auto published = static_cast<std::uint8_t>(write_slot_ | kFresh);
        write_slot_ = shared_.exchange(published, std::memory_order_acq_rel) & kSlotMask;
    }

    /// The newest published value, or the initial one. Reader thread only. RT-safe.
    /// The reference stays valid and unchanged until the next call.
    const Value &latest() noexcept {
        if ((shared_.load(std::memory_order_relaxed) & kFresh) != 0) {
            read_slot_ = shared_.exchange(read_slot_, std::memory_order_acq_rel) & kSlotMask;
        }
        return slots_[read_slot_];
    }

private:
    static constexpr std::uint8_t kFresh = 4;
    static constexpr std::uint8_t kSlotMask = 3;

    std::array<Value, 3> slots_;
    std::atomic<std::uint8_t> shared_{0};
    std::uint8_t write_slot_ = 1;
    std::uint8_t read_slot_ = 2;
};

} // namespace springdrive
