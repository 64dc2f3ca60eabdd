// Steps in a process of their own.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <string>
#include <sys/wait.h>
#include <unistd.h>

namespace springdrive::testing {

/// What `step` says in a process that is prepared for it.
inline std::string said_in_child(const std::function<void()> &prepare,
                                 const std::function<std::string()> &step) {
    std::array<int, 2> ends{};
    EXPECT_EQ(pipe(ends.data()), 0);
    const pid_t child = fork();
    if (child == 0) {
        prepare();
        const std::string said = step();
        const bool sent = write(ends[1], said.data(), said.size()) == std::ssize(said);
        _exit(sent ? 0 : 1);
    }
    close(ends[1]);
    std::string said;
    std::array<char, 4096> part{};
    for (ssize_t got = 0; (got = read(ends[0], part.data(), part.size())) > 0;) {
        said.append(part.data(), static_cast<std::size_t>(got));
    }
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    return said;
}

/// Permissions do not apply to root: a child continues as nobody.
inline void drop_rights() {
    constexpr uid_t kNobody = 65534;
    [[maybe_unused]] const int result = geteuid() == 0 ? setuid(kNobody) : 0;
}

} // namespace springdrive::testing
