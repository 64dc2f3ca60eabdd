#include "app/doctor/child_answer.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>

namespace springdrive::app::doctor {

namespace {

constexpr char kEnd = '\0'; ///< after a complete answer

/// Drivers print to both streams, which belong to the doctor's report.
void close_streams() {
    const int nothing = open("/dev/null", O_RDWR | O_CLOEXEC);
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
        dup2(nothing, stream);
    }
}

void write_all(int pipe, const std::string &answer) {
    for (std::size_t done = 0; done < answer.size();) {
        const ssize_t count = write(pipe, answer.data() + done, answer.size() - done);
        if (count <= 0) {
            return;
        }
        done += static_cast<std::size_t>(count);
    }
}

[[noreturn]] void answer_and_end(int pipe, const std::function<std::string()> &work) noexcept {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    close_streams();
    try {
        write_all(pipe, work() + kEnd);
    } catch (...) { // which answers nothing
        _exit(1);
    }
    _exit(0);
}

} // namespace

ChildAnswer::ChildAnswer(const std::function<std::string()> &work) {
    std::array<int, 2> ends{-1, -1};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) {
        return;
    }
    child_ = fork();
    if (child_ == 0) {
        close(ends[0]);
        answer_and_end(ends[1], work);
    }
    close(ends[1]);
    pipe_ = ends[0];
}

ChildAnswer::~ChildAnswer() {
    if (child_ > 0) {
        kill(child_, SIGKILL);
        // One that waits for a dead disk remains until the disk answers, or this process ends.
        waitpid(child_, nullptr, WNOHANG);
    }
    if (pipe_ >= 0) {
        close(pipe_);
    }
}

std::optional<std::string> ChildAnswer::by(Clock::time_point deadline) {
    std::string answer;
    while (pipe_ >= 0) {
        const auto left =
            std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()).count();
        pollfd waits{pipe_, POLLIN, 0};
        const int ready = poll(&waits, 1, static_cast<int>(std::max<std::int64_t>(0, left)));
        if (ready < 0 && errno == EINTR) {
            continue;
        }
        std::array<char, 4096> block{};
        const ssize_t count = ready > 0 ? read(pipe_, block.data(), block.size()) : 0;
        if (count <= 0) {
            break;
        }
        answer.append(block.data(), static_cast<std::size_t>(count));
        if (answer.back() == kEnd) {
            answer.pop_back();
            return answer;
        }
    }
    return std::nullopt;
}

} // namespace springdrive::app::doctor
