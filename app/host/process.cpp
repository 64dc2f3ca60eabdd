#include "app/host/process.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <fcntl.h>
#include <spawn.h>
#include <string_view>
#include <sys/wait.h>
#include <unistd.h>

namespace springdrive::app {

namespace {

volatile std::sig_atomic_t asked = 0;

extern "C" void on_signal(int /*signal*/) { asked = 1; }

} // namespace

void note_ending_signals() {
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
    if (std::signal(SIGHUP, on_signal) == SIG_IGN) { // the terminal was closed
        std::signal(SIGHUP, SIG_IGN);                // which is to be survived: nohup
    }
}

bool asked_to_end() { return asked != 0; }

namespace {

std::string read_to_the_end(int descriptor) {
    std::string text;
    std::array<char, 4096> block{};
    for (;;) {
        const ssize_t count = read(descriptor, block.data(), block.size());
        if (count > 0) {
            text.append(block.data(), static_cast<std::size_t>(count));
        } else if (count == 0 || errno != EINTR) {
            return text;
        }
    }
}

/// Our environment without GNUTERM, which would make gnuplot open a screen.
std::vector<char *> environment() {
    std::vector<char *> variables;
    for (char **variable = environ; *variable != nullptr; ++variable) {
        if (!std::string_view(*variable).starts_with("GNUTERM=")) {
            variables.push_back(*variable);
        }
    }
    variables.push_back(nullptr);
    return variables;
}

/// The program's streams and folder.
class SpawnSetting {
public:
    SpawnSetting(const std::filesystem::path &folder, ProgramStream stream, int pipe) {
        posix_spawn_file_actions_init(&actions_);
        posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
        if (stream == ProgramStream::error) {
            posix_spawn_file_actions_addopen(&actions_, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
            posix_spawn_file_actions_adddup2(&actions_, pipe, STDERR_FILENO);
        } else {
            posix_spawn_file_actions_adddup2(&actions_, pipe, STDOUT_FILENO);
        }
        posix_spawn_file_actions_addchdir_np(&actions_, folder.c_str());
    }
    ~SpawnSetting() { posix_spawn_file_actions_destroy(&actions_); }
    SpawnSetting(const SpawnSetting &) = delete;
    SpawnSetting &operator=(const SpawnSetting &) = delete;

    [[nodiscard]] const posix_spawn_file_actions_t *actions() const { return &actions_; }

private:
    posix_spawn_file_actions_t actions_{};
};

} // namespace

ProgramEnding run_program(std::vector<std::string> arguments, const std::filesystem::path &folder,
                          ProgramStream stream) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) {
        return {errno, 0, {}};
    }
    std::vector<char *> argv;
    argv.reserve(arguments.size() + 1);
    for (std::string &argument : arguments) {
        argv.push_back(argument.data());
    }
    argv.push_back(nullptr);
    ProgramEnding ending;
    pid_t child = 0;
    {
        const SpawnSetting setting(folder, stream, ends[1]);
        ending.spawn_error = posix_spawnp(&child, argv[0], setting.actions(), nullptr, argv.data(),
                                          environment().data());
    }
    close(ends[1]);
    if (ending.spawn_error == 0) {
        ending.text = read_to_the_end(ends[0]);
        while (waitpid(child, &ending.wait_status, 0) < 0 && errno == EINTR) {
        }
    }
    close(ends[0]);
    return ending;
}

} // namespace springdrive::app
