// Watches threads that must only compute: allocations and locks are counted, and a system call that
// a servo must not make puts the thread to sleep permanently.
//
//   watched thread ──┬─ malloc, free, operator new ... ──► watched().allocations
//                    ├─ pthread_mutex_lock ... ──────────► watched().locks
//                    └─ system call ─► seccomp ─► SIGSYS ► watched().system_call, sleeps forever
//
// Of threads that may allocate, as libusb does with each transfer, those that request a real-time
// priority must do so where they wait for nobody: in an arena of the heap that is theirs alone.
//
//   any thread ──┬─ pthread_setschedparam(SCHED_FIFO) ───► it is a real-time thread
//                └─ malloc ... ─► whose arena is it? ────► watched().shared_allocations
//
// Replaces malloc in the program that it is linked into, as the sanitizers do themselves.
#pragma once

#include <atomic>
#include <functional>

namespace springdrive::testing {

/// Counts over all watched threads of this process.
struct Watched {
    std::atomic<int> allocations{0}; ///< frees are counted too: they may lock
    std::atomic<int> locks{0};
    std::atomic<int> allocating_threads{0}; ///< real-time threads that allocated
    std::atomic<int> shared_allocations{0}; ///< where a real-time and another thread allocate
    std::atomic<int> system_call{-1};       ///< number of a caught system call
    std::atomic<bool> has_filter{false};
};
[[nodiscard]] Watched &watched();

/// While it exists, counts the calling thread's allocations and locks.
class CountingWatch {
public:
    CountingWatch();
    ~CountingWatch();
    CountingWatch(const CountingWatch &) = delete;
    CountingWatch &operator=(const CountingWatch &) = delete;
};

/// From now on, whose arena each allocation is from counts, on all threads of this process. An
/// arena stays a thread's after its end: others may still free in it.
void watch_heaps();

/// Watches the calling thread until its process ends, including system calls: all but reading the
/// clock and sleeping are caught. A filter cannot be removed, so use it in a child process.
void watch_this_thread_for_good();

/// Runs `work` in a child process. If `work` starts threads that cannot be joined, such as
/// permanently watched ones, it must end with `end_this_child`. @return whether `work` failed no
/// expectation; its messages are on standard output
[[nodiscard]] bool holds_in_a_child(const std::function<void()> &work);

/// Ends the child immediately, with all its threads and without destructors.
[[noreturn]] void end_this_child();

/// Whether this kernel allows a process to filter its own system calls.
[[nodiscard]] bool can_filter_system_calls();

} // namespace springdrive::testing
