// Shares work among threads where what is done does not depend on who does it. Starts threads and
// allocates: for preparing, never for the servo.
#pragma once

#include "base/wanted.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <future>
#include <thread>
#include <vector>

namespace springdrive {

/// How many threads to use where nobody says: one for each processor.
[[nodiscard]] inline unsigned all_processors() {
    return std::max(1U, std::thread::hardware_concurrency());
}

/// Calls `work(chunk, first, last)` for `chunks` ranges that together cover 0 to `count`, in order
/// and each in a thread of its own. Returns when all are done.
/// @throw what `work` throws, once all have ended
template <typename Work> void in_chunks(std::size_t count, unsigned chunks, const Work &work) {
    const auto start_of = [&](unsigned chunk) { return count * chunk / chunks; };
    const std::atomic<bool> *const given_up = wanted::is_given_up;
    std::vector<std::future<void>> others;
    for (unsigned chunk = 1; chunk < chunks; ++chunk) {
        others.push_back(std::async(std::launch::async, [&work, start_of, chunk, given_up] {
            const GivenUpBy by(given_up);
            work(chunk, start_of(chunk), start_of(chunk + 1));
        }));
    }
    work(0U, std::size_t{0}, start_of(1));
    for (std::future<void> &other : others) {
        other.get();
    }
}

/// Calls `work(i)` once for each i below `count`, in up to `threads` threads, this one among them;
/// returns when all is done.
/// @throw what `work` threw first, by the order of the threads; NotWanted where the calling
///        thread's work was given up, before the next i
template <typename Work> void for_each_in_parallel(std::size_t count, unsigned threads, Work work) {
    std::atomic<std::size_t> next{0};
    const auto take_turns = [&] {
        for (std::size_t i = next++; i < count; i = next++) {
            stop_if_given_up();
            work(i);
        }
    };
    const std::atomic<bool> *const given_up = wanted::is_given_up;
    // Their destructors wait, whatever is thrown here.
    std::vector<std::future<void>> helpers;
    for (std::size_t i = 1; i < std::min<std::size_t>(count, threads); ++i) {
        helpers.push_back(std::async(std::launch::async, [&take_turns, given_up] {
            const GivenUpBy by(given_up);
            take_turns();
        }));
    }
    take_turns();
    for (std::future<void> &helper : helpers) {
        helper.get();
    }
}

} // namespace springdrive
