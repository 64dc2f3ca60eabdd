#include "engine/servo/real_time.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstring>

namespace springdrive {

namespace {

/// Below the kernel's own threads (99), above everything that a desktop runs.
constexpr int kPriority = 80;

/// More stack than a tick uses by an order of magnitude.
constexpr std::size_t kStackTouched = std::size_t{128} * 1024;

/// The command that lifts one limit for the user who runs it.
std::string allow(const std::string &limit) {
    return "echo \"$USER - " + limit +
           "\" | sudo tee -a /etc/security/limits.d/springdrive.conf, and log in again";
}

void touch_stack() {
    std::array<volatile char, kStackTouched>
        pages; // NOLINT(cppcoreguidelines-pro-type-member-init)
    for (std::size_t i = 0; i < pages.size(); i += 1024) {
        pages[i] = 0;
    }
}

} // namespace

std::vector<std::string> make_this_thread_real_time() {
    std::vector<std::string> remarks;
    sched_param parameters{};
    parameters.sched_priority = kPriority;
    const int refused = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
    if (refused != 0) {
        remarks.push_back("no real-time priority, ticks may come late; " +
                          std::string(std::strerror(refused)) +
                          "; to allow it: " + allow("rtprio 80"));
    }
    // With a limit in force, a lock on future pages would make later allocations fail: leave it
    // then. The superuser's lock knows no limit.
    rlimit limit{};
    const bool unlimited = geteuid() == 0 || (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 &&
                                              limit.rlim_cur == RLIM_INFINITY);
    if (!unlimited || mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
        remarks.push_back("memory may be paged out, ticks may come late; to keep it: " +
                          allow("memlock unlimited"));
    }
    touch_stack();
    return remarks;
}

} // namespace springdrive
