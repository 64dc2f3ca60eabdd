#include "app/figures/gnuplot.h"

#include "base/input_error.h"

#include <fmt/core.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <iterator>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

namespace springdrive::app {

namespace {

/// A program's exit status and its output on standard error.
struct Ending {
    int spawn_error = 0; ///< an errno, if it could not be started
    int wait_status = 0;
    std::string error;
};

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

/// The program's standard input and output (none), standard error (a pipe to us) and folder.
class SpawnSetting {
public:
    SpawnSetting(const std::filesystem::path &folder, int error_descriptor) {
        posix_spawn_file_actions_init(&actions_);
        posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
        posix_spawn_file_actions_addopen(&actions_, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
        posix_spawn_file_actions_adddup2(&actions_, error_descriptor, STDERR_FILENO);
        posix_spawn_file_actions_addchdir_np(&actions_, folder.c_str());
    }
    ~SpawnSetting() { posix_spawn_file_actions_destroy(&actions_); }
    SpawnSetting(const SpawnSetting &) = delete;
    SpawnSetting &operator=(const SpawnSetting &) = delete;

    [[nodiscard]] const posix_spawn_file_actions_t *actions() const { return &actions_; }

private:
    posix_spawn_file_actions_t actions_{};
};

Ending run(std::vector<std::string> arguments, const std::filesystem::path &folder) {
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
    Ending ending;
    pid_t child = 0;
    {
        const SpawnSetting setting(folder, ends[1]);
        ending.spawn_error = posix_spawnp(&child, argv[0], setting.actions(), nullptr, argv.data(),
                                          environment().data());
    }
    close(ends[1]);
    if (ending.spawn_error == 0) {
        ending.error = read_to_the_end(ends[0]);
        while (waitpid(child, &ending.wait_status, 0) < 0 && errno == EINTR) {
        }
    }
    close(ends[0]);
    return ending;
}

/// The last line that is not empty.
std::string last_line(const std::string &text) {
    const std::size_t last = text.find_last_not_of(" \n\r\t");
    if (last == std::string::npos) {
        return "no message";
    }
    const std::size_t before = text.find_last_of('\n', last);
    const std::size_t first = text.find_first_not_of(" \t", before + 1);
    return text.substr(first, last + 1 - first);
}

/// In gnuplot's single quotes, in which the only escape is a doubled quote.
std::string in_single_quotes(std::string_view text) {
    std::string inside;
    for (const char c : text) {
        inside += c == '\'' ? "''" : std::string(1, c == '\n' ? ' ' : c);
    }
    return "'" + inside + "'";
}

bool is_whole(const std::filesystem::path &svg) {
    std::ifstream file(svg, std::ios::binary);
    const std::string text(std::istreambuf_iterator<char>(file), {});
    constexpr std::string_view kEnd = "</svg>";
    const std::size_t end = text.find_last_not_of(" \n");
    return end != std::string::npos && end + 1 >= kEnd.size() &&
           text.compare(end + 1 - kEnd.size(), kEnd.size(), kEnd) == 0;
}

} // namespace

void ChartMarks::add(std::string_view name, double number) {
    assignments_ += fmt::format("{} = {:.17g}; ", name, number);
}

void ChartMarks::add(std::string_view name, std::string_view text) {
    assignments_ += fmt::format("{} = {}; ", name, in_single_quotes(text));
}

void draw(const Chart &chart, Existing existing) {
    const std::filesystem::path svg = chart.folder / chart.svg;
    NewFile drawn(svg);
    const std::string files = "csv = " + in_single_quotes(chart.csv) +
                              "; svg = " + in_single_quotes(drawn.temporary().string()) + "; ";
    // -d: ignore the user's gnuplot settings.
    const std::filesystem::path script = std::filesystem::absolute(chart.script);
    const Ending ending = run({"gnuplot", "-d", "-e", files + chart.assignments,
                               script.parent_path() / "style.gnuplot", script},
                              chart.folder);
    if (ending.spawn_error == ENOENT) {
        throw InputError("gnuplot is not installed; install the package gnuplot-nox (the figures' "
                         "numbers are in " +
                         chart.folder.string() + ", as CSV files)");
    }
    if (ending.spawn_error != 0) {
        throw InputError(
            "gnuplot cannot be started: " +
            std::string(std::strerror(ending.spawn_error))); // NOLINT(concurrency-mt-unsafe)
    }
    if (!WIFEXITED(ending.wait_status) || WEXITSTATUS(ending.wait_status) != 0) {
        throw InputError(svg.string() + ": gnuplot could not draw it: " + last_line(ending.error));
    }
    if (!is_whole(drawn.temporary())) {
        throw InputError(svg.string() + ": gnuplot did not write it completely; is the disk full, "
                                        "or gnuplot built without SVG?");
    }
    drawn.publish(existing);
}

} // namespace springdrive::app
