// Watches threads that must do nothing but compute: what they allocate and lock is counted, and a
// system call that a servo has no business with puts them to sleep for good.
//
//   watched thread ──┬─ malloc, free, operator new ... ──► watched().allocations
//                    ├─ pthread_mutex_lock ... ──────────► watched().locks
//                    └─ system call ─► seccomp ─► SIGSYS ► watched().system_call, sleeps for ever
//
// Takes malloc's place in the program that it is linked into; the sanitizers do so themselves.
#pragma once

#include <atomic>
#include <functional>

namespace springdrive::testing {

/// What all watched threads of this process have done.
struct Watched {
    std::atomic<int> allocations{0}; ///< frees are counted too: they may lock
    std::atomic<int> locks{0};
    std::atomic<int> system_call{-1}; ///< number of the one that was caught
    std::atomic<bool> has_filter{false};
};
[[nodiscard]] Watched &watched();

/// Counts what the calling thread allocates and locks, as long as it lives.
class CountingWatch {
public:
    CountingWatch();
    ~CountingWatch();
    CountingWatch(const CountingWatch &) = delete;
    CountingWatch &operator=(const CountingWatch &) = delete;
};

/// Watches the calling thread from now until its process ends, system calls too: all but reading
/// the clock and sleeping are caught. Nothing takes a filter away again: meant for `in_a_child`.
void watch_this_thread_for_good();

/// Runs `work` in a process of its own. Whoever starts threads there that cannot be joined, as
/// those that are watched for good, ends it with `end_this_child`.
/// @return whether `work` failed no expectation; its messages are on standard output
[[nodiscard]] bool holds_in_a_child(const std::function<void()> &work);

/// Ends the child at once, with all its threads and without any destructor.
[[noreturn]] void end_this_child();

/// Whether this kernel lets a process filter its own system calls.
[[nodiscard]] bool can_filter_system_calls();

} // namespace springdrive::testing
