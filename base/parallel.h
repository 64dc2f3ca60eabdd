// Distributes work over threads when the result does not depend on which thread does which part.
// Starts threads and allocates, so it is for preparation, never for the servo.
#pragma once

#include "base/cancellation.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <future>
#include <thread>
#include <vector>

namespace springdrive {

/// The default number of threads: one per processor.
[[nodiscard]] inline unsigned all_processors() {
    return std::max(1U, std::thread::hardware_concurrency());
}

/// Calls `work(chunk, first, last)` for `chunks` consecutive ranges that together cover 0 to
/// `count`, each in its own thread. Returns when all are done.
/// @throw what `work` throws, after all threads have ended
template <typename Work> void in_chunks(std::size_t count, unsigned chunks, const Work &work) {
    const auto start_of = [&](unsigned chunk) { return count * chunk / chunks; };
    const std::atomic<bool> *const given_up = current_work::is_cancelled;
    std::vector<std::future<void>> others;
    for (unsigned chunk = 1; chunk < chunks; ++chunk) {
        others.push_back(std::async(std::launch::async, [&work, start_of, chunk, given_up] {
            const StopScope by(given_up);
            work(chunk, start_of(chunk), start_of(chunk + 1));
        }));
    }
    work(0U, std::size_t{0}, start_of(1));
    for (std::future<void> &other : others) {
        other.get();
    }
}

/// Calls `work(i)` once for each i below `count`, in up to `threads` threads including the calling
/// one; returns when all are done.
/// @throw what `work` threw, the first in the order of the threads; Cancelled, before the next i,
///        if the calling thread's work was cancelled
template <typename Work> void for_each_in_parallel(std::size_t count, unsigned threads, Work work) {
    std::atomic<std::size_t> next{0};
    const auto take_turns = [&] {
        for (std::size_t i = next++; i < count; i = next++) {
            stop_if_given_up();
            work(i);
        }
    };
    const std::atomic<bool> *const given_up = current_work::is_cancelled;
    // The futures' destructors wait, even if an exception is thrown here.
    std::vector<std::future<void>> helpers;
    for (std::size_t i = 1; i < std::min<std::size_t>(count, threads); ++i) {
        helpers.push_back(std::async(std::launch::async, [&take_turns, given_up] {
            const StopScope by(given_up);
            take_turns();
        }));
    }
    take_turns();
    for (std::future<void> &helper : helpers) {
        helper.get();
    }
}

} // namespace springdrive
