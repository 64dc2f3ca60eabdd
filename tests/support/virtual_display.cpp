#include "tests/support/virtual_display.h"

#include <array>
#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <poll.h>
#include <stdexcept>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

namespace springdrive::testing {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kMaxStart{30};
constexpr std::chrono::seconds kMaxEnd{5};
constexpr int kNotFound = 127; // as shells report a missing program

/// In the child. Never returns.
[[noreturn]] void become_server(std::vector<std::string> words, int number_to, int log,
                                pid_t parent) {
    // Ctrl-C must reach only the test, whose program still needs its display then.
    setsid();
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) {
        _exit(0); // the test ended before the line above
    }
    fcntl(number_to, F_SETFD, 0); // survives the exec
    dup2(log, STDOUT_FILENO);
    dup2(log, STDERR_FILENO);
    words.insert(words.end(), {"-displayfd", std::to_string(number_to)});
    std::vector<char *> argv;
    argv.reserve(words.size() + 1);
    for (std::string &word : words) {
        argv.push_back(word.data());
    }
    argv.push_back(nullptr);
    execvp(argv[0], argv.data());
    _exit(kNotFound);
}

/// The first line, without its end; empty at the end of the stream or of the time.
std::string first_line(int stream) {
    const Clock::time_point deadline = Clock::now() + kMaxStart;
    std::string line;
    char letter = 0;
    for (;;) {
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
        pollfd watched{stream, POLLIN, 0};
        if (left.count() <= 0 || poll(&watched, 1, static_cast<int>(left.count())) == 0 ||
            read(stream, &letter, 1) != 1) {
            return {};
        }
        if (letter == '\n') {
            return line;
        }
        line += letter;
    }
}

/// What the server printed.
std::string contents_of_log(int log) {
    std::array<char, 2000> text{};
    const ssize_t size = pread(log, text.data(), text.size(), 0);
    return {text.data(), size > 0 ? static_cast<std::size_t>(size) : 0U};
}

/// Whether it ended in time.
bool ends_within(pid_t process, std::chrono::seconds limit, int &status) {
    const Clock::time_point deadline = Clock::now() + limit;
    while (waitpid(process, &status, WNOHANG) == 0) {
        if (Clock::now() > deadline) {
            return false;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return true;
}

/// Ends it, and returns its exit status, or −1 if it had to be ended.
int end_server(pid_t server) {
    int status = 0;
    kill(server, SIGTERM); // it then removes its lock file
    if (!ends_within(server, kMaxEnd, status)) {
        kill(server, SIGKILL);
        waitpid(server, &status, 0);
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

} // namespace

VirtualDisplay::VirtualDisplay(int width, int height)
    : VirtualDisplay({"Xvfb", "-screen", "0",
                      std::to_string(width) + "x" + std::to_string(height) + "x24", "+extension",
                      "GLX", "-noreset"}) {}

VirtualDisplay::VirtualDisplay(std::vector<std::string> server) {
    const std::string program = server.front();
    std::array<int, 2> number{};
    const int log = memfd_create("server", MFD_CLOEXEC);
    if (log < 0 || pipe2(number.data(), O_CLOEXEC) != 0) {
        throw std::runtime_error("no virtual display: no pipe to " + program);
    }
    const pid_t parent = getpid();
    server_ = fork();
    if (server_ == 0) {
        become_server(std::move(server), number[1], log, parent);
    }
    close(number[1]);
    const std::string line = server_ > 0 ? first_line(number[0]) : "";
    close(number[0]);
    name_ = ":" + line;
    std::string error;
    if (server_ < 0) {
        error = "no process for " + program;
    } else if (line.empty()) {
        error = end_server(server_) == kNotFound
                    ? program + " is not installed"
                    : program + " did not start: " + contents_of_log(log);
    }
    close(log);
    if (!error.empty()) {
        throw std::runtime_error("no virtual display: " + error);
    }
}

VirtualDisplay::~VirtualDisplay() { end_server(server_); }

void VirtualDisplay::freeze() const { kill(server_, SIGSTOP); }

void VirtualDisplay::go_on() const { kill(server_, SIGCONT); }

} // namespace springdrive::testing
