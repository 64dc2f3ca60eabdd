// Values that one thread hands over to another without waiting: only the newest, or each in turn.
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace springdrive {

/// A mailbox for one writer thread and one reader thread that keeps only the newest value.
///
///   writer:  slots_[w] = value ──► exchange(shared, w) ──► w = what was shared before
///   reader:  if shared is fresh: exchange(shared, r)   ──► slots_[r] is the newest value
///
/// Three slots, one atomic byte. Neither side ever waits, allocates or sees a partly written value.
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

/// A queue of samples from one writer thread to one reader thread. The writer never waits: when the
/// ring is full, the new sample is dropped and counted.
template <typename Sample> class SampleRing {
public:
    /// @throw std::invalid_argument unless `capacity` is a power of two.
    explicit SampleRing(std::size_t capacity) : samples_(capacity), mask_(capacity - 1) {
        if (!std::has_single_bit(capacity)) {
            throw std::invalid_argument("SampleRing: the capacity must be a power of two");
        }
    }

    /// Writer thread only. RT-safe. Returns false, and counts a loss, when the ring is full.
    bool push(const Sample &sample) noexcept {
        const std::size_t head = head_.load(std::memory_order_relaxed);
        if (head - tail_.load(std::memory_order_acquire) == samples_.size()) {
            lost_.fetch_add(1, std::memory_order_relaxed);
            return false;
        }
        samples_[head & mask_] = sample;
        head_.store(head + 1, std::memory_order_release);
        return true;
    }

    /// Passes every queued sample to `take`, oldest first. Reader thread only.
    template <typename Take> void drain(Take &&take) {
        const std::size_t head = head_.load(std::memory_order_acquire);
        std::size_t tail = tail_.load(std::memory_order_relaxed);
        while (tail != head) {
            take(samples_[tail & mask_]);
            tail_.store(++tail, std::memory_order_release);
        }
    }

    /// The oldest queued sample. Reader thread only. RT-safe. @return false if there is none
    bool pop(Sample &sample) noexcept {
        const std::size_t tail = tail_.load(std::memory_order_relaxed);
        if (tail == head_.load(std::memory_order_acquire)) {
            return false;
        }
        sample = samples_[tail & mask_];
        tail_.store(tail + 1, std::memory_order_release);
        return true;
    }

    /// Samples dropped because the reader was too slow. Any thread.
    [[nodiscard]] std::uint64_t lost() const noexcept {
        return lost_.load(std::memory_order_relaxed);
    }

private:
    std::vector<Sample> samples_;
    std::size_t mask_;
    alignas(64) std::atomic<std::size_t> head_{0};
    alignas(64) std::atomic<std::size_t> tail_{0};
    std::atomic<std::uint64_t> lost_{0};
};

} // namespace springdrive
