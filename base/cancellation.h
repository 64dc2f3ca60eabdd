// Cancellation of long work: a thread registers once the flag that cancels its work, and loops deep
// in the call tree check it, so that the functions in between need not pass it on.
#pragma once

#include <atomic>
#include <cstddef>
#include <stdexcept>

namespace springdrive {

/// The work in progress was cancelled.
class Cancelled : public std::runtime_error {
public:
    Cancelled() : std::runtime_error("given up") {}
};

namespace current_work {

/// The flag of this thread's work; null if the work cannot be cancelled.
inline thread_local const std::atomic<bool> *is_cancelled = nullptr;

} // namespace current_work

/// During its lifetime that flag cancels this thread's work. `in_chunks` and `for_each_in_parallel`
/// pass the flag on to the threads that they start.
class StopScope {
public:
    /// @param is_cancelled  must outlive it; null for none
    explicit StopScope(const std::atomic<bool> *is_cancelled)
        : before_(current_work::is_cancelled) {
        current_work::is_cancelled = is_cancelled;
    }
    ~StopScope() { current_work::is_cancelled = before_; }
    StopScope(const StopScope &) = delete;
    StopScope &operator=(const StopScope &) = delete;

private:
    const std::atomic<bool> *before_;
};

/// Costs one load of a flag.
/// @throw Cancelled if this thread's work was cancelled
inline void stop_if_given_up() {
    if (current_work::is_cancelled != nullptr &&
        current_work::is_cancelled->load(std::memory_order_relaxed)) {
        throw Cancelled();
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
