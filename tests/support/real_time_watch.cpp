#include "tests/support/real_time_watch.h"

#include <gtest/gtest.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <ctime>

#include <csignal>
#include <dlfcn.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

namespace {

thread_local bool is_watched = false;

void count(std::atomic<int> &counter) {
    if (is_watched) {
        ++counter;
    }
}

void count_allocation() { count(springdrive::testing::watched().allocations); }

// Arenas in the order of their first use. As malloc may not allocate, there is room for a fixed
// number.

struct Arena {
    std::atomic<const void *> address{nullptr};
    std::atomic<int> first_thread{0};
    std::atomic<bool> is_real_time{false}; ///< one of its threads is
    std::atomic<bool> is_shared{false};
};

constinit std::array<Arena, 256> arenas; // NOLINT
std::atomic<bool> is_watching{false};    // NOLINT
std::atomic<int> numbered_threads{0};    // NOLINT
thread_local int thread_number = 0;      ///< 0: none yet
thread_local bool is_real_time = false;
thread_local bool has_allocated = false;

/// The arena of glibc that this memory is from; null if it was mapped by itself.
const void *arena_of(const void *memory) {
    static constexpr char kMain = 0;
    constexpr std::size_t kIsMapped = 2;
    constexpr std::size_t kIsNotOfMain = 4;
    constexpr std::uintptr_t kHeap_bytes = std::uintptr_t{64} << 20U;
    const std::size_t size_and_flags = static_cast<const std::size_t *>(memory)[-1];
    if ((size_and_flags & kIsMapped) != 0) {
        return nullptr;
    }
    if ((size_and_flags & kIsNotOfMain) == 0) {
        return &kMain;
    }
    const auto heap = reinterpret_cast<std::uintptr_t>(memory) & ~(kHeap_bytes - 1);
    return *reinterpret_cast<const void *const *>(heap);
}

void record_use(Arena &arena) {
    springdrive::testing::Watched &watched = springdrive::testing::watched();
    int nobody = 0;
    if (!arena.first_thread.compare_exchange_strong(nobody, thread_number) &&
        nobody != thread_number) {
        arena.is_shared = true;
    }
    if (is_real_time) {
        arena.is_real_time = true;
        watched.allocating_threads += has_allocated ? 0 : 1;
        has_allocated = true;
    }
    if (arena.is_shared && arena.is_real_time) {
        ++watched.shared_allocations;
    }
}

void *from_arena(void *memory) {
    const void *const from = is_watching && memory != nullptr ? arena_of(memory) : nullptr;
    if (from == nullptr) {
        return memory;
    }
    if (thread_number == 0) {
        thread_number = ++numbered_threads;
    }
    for (Arena &arena : arenas) {
        const void *none = nullptr;
        if (arena.address.compare_exchange_strong(none, from) || none == from) {
            record_use(arena);
            return memory;
        }
    }
    ++springdrive::testing::watched().shared_allocations; // unknown: too many
    return memory;
}

/// The C library's function behind a name that is overridden here.
template <typename Function> Function behind(const char *name) {
    return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

using MutexCall = int (*)(pthread_mutex_t *);
using ReadWriteCall = int (*)(pthread_rwlock_t *);
using ScheduleCall = int (*)(pthread_t, int, const sched_param *);

} // namespace

// glibc's allocator behind the names that are overridden here.
extern "C" {
void *__libc_malloc(std::size_t size);                      // NOLINT
void *__libc_calloc(std::size_t count, std::size_t size);   // NOLINT
void *__libc_realloc(void *memory, std::size_t size);       // NOLINT
void *__libc_memalign(std::size_t align, std::size_t size); // NOLINT
void __libc_free(void *memory);                             // NOLINT

void *malloc(std::size_t size) {
    count_allocation();
    return from_arena(__libc_malloc(size));
}
void *calloc(std::size_t number, std::size_t size) {
    count_allocation();
    return from_arena(__libc_calloc(number, size));
}
void *realloc(void *memory, std::size_t size) {
    count_allocation();
    return from_arena(__libc_realloc(memory, size));
}
void *aligned_alloc(std::size_t align, std::size_t size) {
    count_allocation();
    return from_arena(__libc_memalign(align, size));
}
int posix_memalign(void **memory, std::size_t align, std::size_t size) {
    count_allocation();
    *memory = from_arena(__libc_memalign(align, size));
    return *memory == nullptr ? ENOMEM : 0;
}
void free(void *memory) {
    count_allocation();
    __libc_free(memory);
}

int pthread_setschedparam(pthread_t thread, int policy, const sched_param *parameters) {
    static const auto real = behind<ScheduleCall>("pthread_setschedparam");
    if (policy == SCHED_FIFO && pthread_equal(thread, pthread_self()) != 0) {
        is_real_time = true; // whether or not it is granted here
    }
    return real(thread, policy, parameters);
}
int pthread_mutex_lock(pthread_mutex_t *mutex) {
    static const auto real = behind<MutexCall>("pthread_mutex_lock");
    count(springdrive::testing::watched().locks);
    return real(mutex);
}
int pthread_mutex_trylock(pthread_mutex_t *mutex) {
    static const auto real = behind<MutexCall>("pthread_mutex_trylock");
    count(springdrive::testing::watched().locks);
    return real(mutex);
}
int pthread_rwlock_rdlock(pthread_rwlock_t *lock) {
    static const auto real = behind<ReadWriteCall>("pthread_rwlock_rdlock");
    count(springdrive::testing::watched().locks);
    return real(lock);
}
int pthread_rwlock_wrlock(pthread_rwlock_t *lock) {
    static const auto real = behind<ReadWriteCall>("pthread_rwlock_wrlock");
    count(springdrive::testing::watched().locks);
    return real(lock);
}
}

namespace springdrive::testing {

namespace {

/// Reading the clock and sleeping; returning from the handler below; and the end of the process, so
/// that any thread may call `exit`.
constexpr std::array kAllowed{SYS_clock_nanosleep, SYS_clock_gettime, SYS_restart_syscall,
                              SYS_rt_sigreturn, SYS_exit_group};

/// A child that takes longer counts as hung.
constexpr unsigned kTimeout_s = 100;

/// A watched thread that made another call sleeps from here on, so that it makes no more. The
/// process that waits for it sees the number.
[[noreturn]] void put_to_sleep(int /*signal*/, siginfo_t *info, void * /*context*/) {
    watched().system_call = info->si_syscall;
    constexpr timespec kLong{3600, 0};
    for (;;) {
        clock_nanosleep(CLOCK_MONOTONIC, 0, &kLong, nullptr);
    }
}

/// For the calling thread only. It is not a security measure, so it checks only the number, not
/// other system call tables.
bool install_filter() {
    constexpr std::size_t kLength = 2 + 2 * kAllowed.size();
    std::array<sock_filter, kLength> program{};
    std::size_t next = 0;
    program[next++] = BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr));
    for (const long call : kAllowed) {
        program[next++] = BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<__u32>(call), 0, 1);
        program[next++] = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
    }
    program[next++] = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP);
    const sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
    return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
           prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) == 0;
}

} // namespace

Watched &watched() {
    static constinit Watched done;
    return done;
}

void watch_heaps() { is_watching = true; }

CountingWatch::CountingWatch() { is_watched = true; }
CountingWatch::~CountingWatch() { is_watched = false; }

void watch_this_thread_for_good() {
    struct sigaction action {};
    action.sa_sigaction = put_to_sleep;
    action.sa_flags = SA_SIGINFO;
    watched().has_filter = sigaction(SIGSYS, &action, nullptr) == 0 && install_filter();
    is_watched = true;
}

void end_this_child() {
    static_cast<void>(std::fflush(nullptr));
    _exit(::testing::Test::HasFailure() ? 1 : 0);
}

bool holds_in_a_child(const std::function<void()> &work) {
    static_cast<void>(std::fflush(nullptr));
    const pid_t child = fork();
    if (child == 0) {
        alarm(kTimeout_s);
        work();
        end_this_child();
    }
    int status = 0;
    EXPECT_EQ(waitpid(child, &status, 0), child);
    EXPECT_FALSE(WIFSIGNALED(status)) << "by signal " << WTERMSIG(status);
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

bool can_filter_system_calls() {
    return holds_in_a_child([] { _exit(install_filter() ? 0 : 1); });
}

} // namespace springdrive::testing
