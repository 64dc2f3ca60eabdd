// Covers engine/servo/real_time.cpp: what the system grants a thread, and the warnings if it
// refuses.
#include "engine/servo/real_time.h"

#include "tests/support/error_text.h"

#include <gtest/gtest.h>

#include <linux/capability.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::servo {
namespace {

std::vector<int> allowed_processors() {
    cpu_set_t allowed;
    CPU_ZERO(&allowed);
    sched_getaffinity(0, sizeof allowed, &allowed);
    std::vector<int> processors;
    for (int i = 0; i < CPU_SETSIZE; ++i) {
        if (CPU_ISSET(static_cast<std::size_t>(i), &allowed)) {
            processors.push_back(i);
        }
    }
    return processors;
}

/// Drops privileges to an ordinary user with the limits of a fresh installation.
bool give_up_rights() {
    const rlimit none{0, 0};
    const rlimit little{65'536, 65'536};
    __user_cap_header_struct head{_LINUX_CAPABILITY_VERSION_3, 0};
    __user_cap_data_struct nothing[2]{}; // NOLINT(modernize-avoid-c-arrays)
    return setrlimit(RLIMIT_RTPRIO, &none) == 0 && setrlimit(RLIMIT_MEMLOCK, &little) == 0 &&
           syscall(SYS_capset, &head, nothing) == 0;
}

/// The text that `says` returns in a child process.
std::string said_elsewhere(const std::function<std::string()> &says) {
    int ends[2]{}; // NOLINT(modernize-avoid-c-arrays)
    EXPECT_EQ(pipe(ends), 0);
    const pid_t child = fork();
    if (child == 0) {
        const std::string said = says();
        _exit(write(ends[1], said.data(), said.size()) < 0 ? 1 : 0);
    }
    close(ends[1]);
    std::string said;
    char letter = 0;
    while (read(ends[0], &letter, 1) == 1) {
        said += letter;
    }
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
    return said;
}

TEST(Rights, EachRefusalIsReportedWithItsRemedy) {
    const std::string said = said_elsewhere([] {
        std::string all;
        if (!give_up_rights()) {
            return std::string("rights stay");
        }
        for (const std::string &warning : make_this_thread_real_time(std::nullopt)) {
            all += warning + "\n";
        }
        return all;
    });
    const std::string priority = "no real-time priority, ticks may come late (Operation not "
                                 "permitted); springdrive doctor has the line that permits it\n";
    const std::string memory =
        "memory may be paged out, ticks may come late; springdrive doctor has "
        "the line that permits it\n";
    EXPECT_EQ(said.substr(0, priority.size()), priority);
    EXPECT_NE(said.find(memory), std::string::npos) << said;
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 2) << said;
}

TEST(Rights, AThreadStaysOnTheGivenProcessor) {
    for (const int cpu : allowed_processors()) {
        EXPECT_NO_THROW(check_cpu(cpu));
        const std::string said = said_elsewhere([cpu] {
            static_cast<void>(make_this_thread_real_time(cpu));
            std::string processors;
            for (const int allowed : allowed_processors()) {
                processors += std::to_string(allowed) + " ";
            }
            return processors;
        });
        EXPECT_EQ(said, std::to_string(cpu) + " ");
    }
}

TEST(Rights, AMissingProcessorIsRejectedByNumber) {
    for (const int cpu : {-1, 1023, 1024, 1'000'000}) {
        const std::string said = testing::error_text_of([cpu] { check_cpu(cpu); });
        EXPECT_EQ(said.find("--cpu " + std::to_string(cpu) + ": this process may run on "), 0U)
            << said;
    }
    const std::string said = said_elsewhere([] {
        std::string all;
        for (const std::string &warning : make_this_thread_real_time(1023)) {
            all += warning + "\n";
        }
        return all;
    });
    EXPECT_NE(said.find("processor 1023 was refused"), std::string::npos) << said;
}

} // namespace
} // namespace springdrive::servo
