#include "base/real_time_thread.h"

#include <condition_variable>
#include <cstdlib>
#include <deque>
#include <latch>
#include <mutex>
#include <thread>
#include <utility>

#include <malloc.h>
#include <pthread.h>
#include <sched.h>

namespace springdrive {

namespace {

using Task = std::packaged_task<void()>;

/// For a board's port, and for what borrows the device.
constexpr int kReserved = 2;

/// Never destroyed: its threads wait until the process ends.
class ReservedThreads {
public:
    ReservedThreads() {
        for (int i = 0; i < kReserved; ++i) {
            std::thread([this] { serve(); }).detach();
        }
        have_heaps_.wait();
    }

    /// @return whether a thread is free; it then runs `work`
    bool run(const std::function<void()> &work, std::future<void> &end) {
        const std::lock_guard lock(mutex_);
        if (free_ == 0) {
            return false;
        }
        --free_;
        // Free again before its end is known.
        Task task([this, work] {
            work();
            const std::lock_guard free_again(mutex_);
            ++free_;
        });
        end = task.get_future();
        tasks_.push_back(std::move(task));
        wake_.notify_one();
        return true;
    }

private:
    [[noreturn]] void serve() {
        void *volatile first = std::malloc(1); // NOLINT: assigns an arena to this thread
        std::free(first);                      // NOLINT
        have_heaps_.count_down();
        for (;;) {
            std::unique_lock lock(mutex_);
            wake_.wait(lock, [this] { return !tasks_.empty(); });
            Task task = std::move(tasks_.front());
            tasks_.pop_front();
            lock.unlock();
            task();
        }
    }

    std::latch have_heaps_{kReserved};
    std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<Task> tasks_; ///< at most one for each free thread
    int free_ = kReserved;
};

ReservedThreads *reserved = nullptr; // NOLINT: set before other threads start

} // namespace

int request_priority(int priority) {
    sched_param parameters{};
    parameters.sched_priority = priority;
    return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
}

bool reserve_heaps() {
    if (reserved != nullptr) {
        return true;
    }
#ifdef __GLIBC__
    constexpr int kMaxArenas = 4096; // more than threads: none is shared
    // Locked memory that is freed within an arena is never given back, but what is mapped by itself
    // is: so hours of scene after scene do not add up.
    constexpr int kMapped_bytes = 256 * 1024;
    const bool is_set_up =
        mallopt(M_ARENA_MAX, kMaxArenas) == 1 && mallopt(M_MMAP_THRESHOLD, kMapped_bytes) == 1;
#else
    const bool is_set_up = false;
#endif
    reserved = new ReservedThreads; // NOLINT(cppcoreguidelines-owning-memory)
    return is_set_up;
}

std::future<void> run_on_own_heap(std::function<void()> work) {
    std::future<void> end;
    cpu_set_t processors;
    CPU_ZERO(&processors);
    sched_getaffinity(0, sizeof processors, &processors);
    const std::function<void()> placed = [processors, work = std::move(work)] {
        static_cast<void>(sched_setaffinity(0, sizeof processors, &processors));
        work();
    };
    if (reserved == nullptr || !reserved->run(placed, end)) {
        end = std::async(std::launch::async, placed);
    }
    return end;
}

} // namespace springdrive
