// Cancellation of long work: a thread registers once the flag that cancels its work, and loops deep
// in the call tree check it, so that the functions in between need not pass it on.
#pragma once

#include <atomic>
#include <cstddef>
#include <stdexcept>

namespace springdrive {

/// The work in progress was cancelled.
class NotWanted : public std::runtime_error {
public:
    NotWanted() : std::runtime_error("given up") {}
};

namespace wanted {

/// The flag of this thread's work; null if the work cannot be cancelled.
inline thread_local const std::atomic<bool> *is_given_up = nullptr;

} // namespace wanted

/// During its lifetime that flag cancels this thread's work. `in_chunks` and `for_each_in_parallel`
/// pass the flag on to the threads that they start.
class GivenUpBy {
public:
    /// @param is_given_up  must outlive it; null for none
    explicit GivenUpBy(const std::atomic<bool> *is_given_up) : before_(wanted::is_given_up) {
        wanted::is_given_up = is_given_up;
    }
    ~GivenUpBy() { wanted::is_given_up = before_; }
    GivenUpBy(const GivenUpBy &) = delete;
    GivenUpBy &operator=(const GivenUpBy &) = delete;

private:
    const std::atomic<bool> *before_;
};

/// Costs one load of a flag.
/// @throw NotWanted if this thread's work was cancelled
inline void stop_if_given_up() {
    if (wanted::is_given_up != nullptr && wanted::is_given_up->load(std::memory_order_relaxed)) {
        throw NotWanted();
    }
}

/// The same for a tight loop, with negligible overhead.
/// @param step  the loop's counter, starting anywhere; only every 16,384th step checks
inline void stop_if_given_up(std::size_t step) {
    constexpr std::size_t kBetweenLooks = 16'384;
    if (step % kBetweenLooks == 0) {
        stop_if_given_up();
    }
}

} // namespace springdrive
