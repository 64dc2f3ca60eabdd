#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <sys/wait.h>
#include <system_error>
#include <thread>
#include <unistd.h>

namespace springdrive::testing {

namespace {

constexpr std::chrono::minutes kMax{2};

/// In the child: both streams into files, then the program. Never returns.
[[noreturn]] void become_program(const std::vector<std::string> &arguments,
                                 const std::filesystem::path &folder) {
    const auto redirect = [](int stream, const std::filesystem::path &file) {
        const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
        dup2(descriptor, stream);
    };
    // Graphics drivers leak memory when they are unloaded; our own leaks show in the tests that run
    // within the test program.
    setenv("ASAN_OPTIONS", "detect_leaks=0", 1); // NOLINT(concurrency-mt-unsafe)
    std::signal(SIGXFSZ, SIG_DFL); // as a shell starts it, whatever FullDisk needs here
    redirect(STDOUT_FILENO, folder / "out");
    redirect(STDERR_FILENO, folder / "error");
    std::vector<char *> argv;
    std::string program = SPRINGDRIVE_PROGRAM;
    std::vector<std::string> copies = arguments;
    argv.push_back(program.data());
    for (std::string &argument : copies) {
        argv.push_back(argument.data());
    }
    argv.push_back(nullptr);
    execv(program.c_str(), argv.data());
    _exit(127);
}

} // namespace

Ending run_program(const std::vector<std::string> &arguments, int signal,
                   const std::filesystem::path &started) {
    const std::filesystem::path folder = fresh_folder("streams");
    const pid_t child = fork();
    if (child == 0) {
        become_program(arguments, folder);
    }
    using Clock = std::chrono::steady_clock;
    const Clock::time_point start = Clock::now();
    Clock::time_point signalled = start;
    bool to_be_signalled = signal != 0;
    int status = 0;
    while (waitpid(child, &status, WNOHANG) == 0) {
        std::error_code not_there;
        if (to_be_signalled && std::filesystem::file_size(started, not_there) > 0 && !not_there) {
            to_be_signalled = false;
            signalled = Clock::now();
            kill(child, signal);
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        if (Clock::now() - start > kMax) {
            kill(child, SIGKILL);
        }
    }
    Ending ending;
    ending.exit_status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    ending.out = contents_of(folder / "out");
    ending.error = contents_of(folder / "error");
    ending.after_signal = Clock::now() - signalled;
    std::filesystem::remove_all(folder);
    return ending;
}

void expect_one_line(const Ending &ending, int status, const std::string &names) {
    EXPECT_EQ(ending.exit_status, status);
    EXPECT_EQ(std::count(ending.error.begin(), ending.error.end(), '\n'), 1) << ending.error;
    EXPECT_NE(ending.error.find(names), std::string::npos) << ending.error;
}

void expect_refused(const Ending &ending, const std::string &names) {
    EXPECT_TRUE(ending.exit_status == 1 || ending.exit_status == 2)
        << names << ": " << ending.exit_status;
    EXPECT_EQ(std::count(ending.error.begin(), ending.error.end(), '\n'), 1) << ending.error;
    EXPECT_EQ(ending.error.substr(0, 13), "springdrive: ") << ending.error;
    EXPECT_NE(ending.error.find(names), std::string::npos) << ending.error;
    EXPECT_EQ(ending.out, "");
}

} // namespace springdrive::testing
