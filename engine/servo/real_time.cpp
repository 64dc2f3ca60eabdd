#include "engine/servo/real_time.h"

#include "base/input_error.h"
#include "base/real_time_thread.h"

#include <fmt/format.h>

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace springdrive::servo {

namespace {

/// An order of magnitude more stack than a tick uses.
constexpr std::size_t kStackTouched = std::size_t{128} * 1024;

constexpr const char *kIdleFile = "/dev/cpu_dma_latency";

/// It knows what the system has already, and who is in which group.
constexpr const char *kRemedy = "springdrive doctor has the line that permits it";

std::string ask_for_priority() {
    const int refused = request_priority(kServoPriority);
    // 1 ns, for threads without real-time priority: the default timer slack wakes them up to 50 µs
    // late.
    static_cast<void>(prctl(PR_SET_TIMERSLACK, 1UL));
    return refused == 0 ? ""
                        : fmt::format("no real-time priority, ticks may come late ({}); {}",
                                      std::strerror(refused), kRemedy);
}

std::string ask_for_memory() {
    return request_locked_memory()
               ? ""
               : fmt::format("memory may be paged out, ticks may come late; {}", kRemedy);
}

std::string ask_for_processor(int cpu) {
    cpu_set_t only;
    CPU_ZERO(&only);
    CPU_SET(static_cast<std::size_t>(cpu), &only);
    const int refused = pthread_setaffinity_np(pthread_self(), sizeof only, &only);
    return refused == 0 ? ""
                        : "processor " + std::to_string(cpu) + " was refused (" +
                              std::strerror(refused) + "); name another with --cpu";
}

void touch_stack() {
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init): written to below
    std::array<volatile char, kStackTouched> pages;
    for (std::size_t i = 0; i < pages.size(); i += 1024) {
        pages[i] = 0;
    }
}

} // namespace

bool request_locked_memory() {
    rlimit limit{};
    const bool unlimited = geteuid() == 0 || (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 &&
                                              limit.rlim_cur == RLIM_INFINITY);
    return unlimited && mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
}

std::vector<std::string> make_this_thread_real_time(std::optional<int> cpu) {
    std::vector<std::string> warnings;
    const auto keep = [&warnings](std::string warning) {
        if (!warning.empty()) {
            warnings.push_back(std::move(warning));
        }
    };
    keep(ask_for_priority());
    keep(ask_for_memory());
    if (cpu) {
        keep(ask_for_processor(*cpu));
    }
    touch_stack();
    return warnings;
}

ShortIdle::ShortIdle() : file_(open(kIdleFile, O_WRONLY | O_CLOEXEC)) {
    const std::int32_t longest_us = 0;
    if (file_ >= 0 && write(file_, &longest_us, sizeof longest_us) == sizeof longest_us) {
        return;
    }
    const bool has_none = errno == ENOENT;
    warning_ = "processors may idle deeply, ticks may come some 0.1 ms late; ";
    if (has_none) {
        warning_ += "this system has no ";
        warning_ += kIdleFile;
    } else {
        warning_ += "to allow it: echo 'KERNEL==\"cpu_dma_latency\", MODE=\"0666\"' | sudo tee "
                    "/etc/udev/rules.d/99-springdrive.rules, and restart";
    }
}

ShortIdle::~ShortIdle() {
    if (file_ >= 0) {
        close(file_);
    }
}

void keep_off_cpu(int cpu) noexcept {
    cpu_set_t allowed;
    CPU_ZERO(&allowed);
    sched_getaffinity(0, sizeof allowed, &allowed);
    CPU_CLR(static_cast<std::size_t>(cpu), &allowed);
    if (CPU_COUNT(&allowed) > 0) {
        static_cast<void>(sched_setaffinity(0, sizeof allowed, &allowed));
    }
}

void check_cpu(int cpu) {
    cpu_set_t allowed;
    CPU_ZERO(&allowed);
    sched_getaffinity(0, sizeof allowed, &allowed);
    if (cpu >= 0 && cpu < CPU_SETSIZE && CPU_ISSET(static_cast<std::size_t>(cpu), &allowed)) {
        return;
    }
    std::string names;
    for (int i = 0; i < CPU_SETSIZE; ++i) {
        if (CPU_ISSET(static_cast<std::size_t>(i), &allowed)) {
            names += (names.empty() ? "" : ", ") + std::to_string(i);
        }
    }
    throw InputError("--cpu " + std::to_string(cpu) + ": this process may run on processors " +
                     names + " only");
}

} // namespace springdrive::servo
