// Threads that keep deadlines, and allocate without waiting for other threads.
//
// glibc locks an arena of the heap during each allocation. A thread has an arena to itself unless
// their number is limited, or it inherits the arena of a thread that ended, in which others still
// free what that one allocated. Threads that are reserved when the program starts inherit none:
//
//   reserved thread ──calloc──► its own arena      never locked by another thread, as long as its
//   loading threads ──malloc──► arenas of theirs   blocks are not freed elsewhere
#pragma once

#include <functional>
#include <future>

namespace springdrive {

/// Requests SCHED_FIFO for the calling thread.
/// @return 0, or the errno of the refusal
[[nodiscard]] int request_priority(int priority);

/// Gives each thread an arena, and starts the reserved threads. Call before other threads start; a
/// second call does nothing. A process that forks afterwards has them in the parent only.
/// @return false if the heap cannot be set up so
[[nodiscard]] bool reserve_heaps();

/// Runs `work`, which throws nothing, on a reserved thread, on the processors of the calling one;
/// if none is free, on a new thread, whose allocations may wait.
[[nodiscard]] std::future<void> run_on_own_heap(std::function<void()> work);

} // namespace springdrive
