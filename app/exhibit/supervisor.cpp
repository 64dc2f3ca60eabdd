#include "app/exhibit/supervisor.h"

#include "app/ending_signal.h"
#include "app/exhibit/day_log.h"
#include "base/input_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <fstream>
#include <iostream>
#include <string>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <vector>

namespace springdrive::app::exhibit {

namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

constexpr Seconds kLook{0.05};
constexpr Seconds kPatience{20.0}; ///< with a child that was asked to end
constexpr int kBySignal = 128;     ///< of an exit status: plus the signal's number

/// As this program was started.
std::vector<std::string> own_arguments() {
    std::ifstream file("/proc/self/cmdline", std::ios::binary);
    std::vector<std::string> words;
    for (std::string word; std::getline(file, word, '\0');) {
        words.push_back(word);
    }
    return words;
}

/// This process has no thread but its first, so it may fork.
pid_t start_child(std::vector<std::string> words) {
    std::vector<char *> argv;
    argv.reserve(words.size() + 1);
    for (std::string &word : words) {
        argv.push_back(word.data());
    }
    argv.push_back(nullptr);
    const pid_t parent = getpid();
    const pid_t child = fork();
    if (child < 0) {
        throw InputError("--kiosk: no second process can be started (" +
                         std::system_category().message(errno) +
                         "); end other programs, or start it with --unsupervised");
    }
    if (child == 0) {
        prctl(PR_SET_PDEATHSIG, SIGTERM);
        if (getppid() != parent) {
            _exit(0); // it ended before the line above
        }
        execv("/proc/self/exe", argv.data());
        _exit(127);
    }
    return child;
}

ChildEnd wait_for(pid_t child) {
    const Clock::time_point start = Clock::now();
    std::optional<Clock::time_point> asked;
    int status = 0;
    while (waitpid(child, &status, WNOHANG) == 0) {
        if (asked_to_end() && !asked) {
            asked = Clock::now();
            kill(child, SIGTERM);
        } else if (asked && Clock::now() - *asked > kPatience) {
            kill(child, SIGKILL);
        }
        std::this_thread::sleep_for(kLook);
    }
    return {WIFSIGNALED(status) ? kBySignal + WTERMSIG(status) : WEXITSTATUS(status),
            Seconds(Clock::now() - start).count()};
}

} // namespace

std::optional<double> RestartPolicy::pause_s(const ChildEnd &end) {
    constexpr int kMistake = 1; // of input, or of usage: one more
    const bool was_mistaken = end.status == kMistake || end.status == kMistake + 1;
    const bool was_proven = end.lived_s >= kProven_s;
    is_proven_ = is_proven_ || was_proven;
    if (end.status == 0 || (was_mistaken && !is_proven_)) {
        return std::nullopt;
    }
    const double pause_s = was_proven ? kFirst_s : next_s_;
    next_s_ = std::min(2.0 * pause_s, kLongest_s);
    return pause_s;
}

int supervise(const std::filesystem::path &log) {
    note_ending_signals();
    std::vector<std::string> words = own_arguments();
    words.emplace_back("--unsupervised");
    RestartPolicy policy;
    DayLog day_log(log);
    for (;;) {
        const ChildEnd end = wait_for(start_child(words));
        if (asked_to_end() && end.status == kBySignal + SIGTERM) { // it had just begun to start
            day_log.note("end, by a signal, before the window was there");
            return 0;
        }
        const std::optional<double> pause_s = policy.pause_s(end);
        if (!pause_s || asked_to_end()) {
            return end.status;
        }
        const std::string what =
            fmt::format("ended with status {} after {:.0f} s; started again in {:.0f} s",
                        end.status, end.lived_s, *pause_s);
        day_log.note(what);
        std::cerr << "springdrive: the kiosk " << what << '\n';
        const Clock::time_point then =
            Clock::now() + std::chrono::duration_cast<Clock::duration>(Seconds(*pause_s));
        while (Clock::now() < then && !asked_to_end()) {
            std::this_thread::sleep_for(kLook);
        }
        if (asked_to_end()) {
            return 0;
        }
    }
}

} // namespace springdrive::app::exhibit
