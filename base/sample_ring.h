// A queue of samples from one writer thread to one reader thread. The writer never waits: when the
// ring is full, the new sample is dropped and counted.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace springdrive {

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
