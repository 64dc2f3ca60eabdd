// The springdrive program while it runs, with a window and a conversation over its streams.
#pragma once

#include "tests/support/program.h"
#include "tests/support/virtual_display.h"

#include <chrono>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <sys/types.h>
#include <thread>
#include <vector>

namespace springdrive::testing {

/// It is killed with this object, and with the thread that created it. A thread of its own reads
/// its standard output at all times: the program never waits for the test to read.
class RunningProgram {
public:
    /// @param folder  where the program runs; empty for the folder of the test
    /// @throw std::runtime_error  the system has no process or no pipe for it
    RunningProgram(const VirtualDisplay &display, const std::vector<std::string> &arguments,
                   const std::filesystem::path &folder = {});
    ~RunningProgram();
    RunningProgram(const RunningProgram &) = delete;
    RunningProgram &operator=(const RunningProgram &) = delete;

    /// Writes `line` and a line end to its standard input.
    /// @throw std::runtime_error  the program has ended or closed it, or does not read for 60 s
    void send_line(const std::string &line);

    /// The next line of its standard output, without its end.
    /// @param timeout  60 s at most
    /// @return nothing if none came in time, or none will come as the program has ended
    [[nodiscard]] std::optional<std::string> read_line(std::chrono::duration<double> timeout);

    [[nodiscard]] bool is_running();
    [[nodiscard]] pid_t process() const { return process_; }

    /// What it wrote to standard error so far.
    [[nodiscard]] std::string error() const;

    /// Closes its standard input and waits for its end; kills it after 60 s, which is exit
    /// status −1. A second call returns the same.
    /// @param signal  sent first; 0 for none
    /// @return with the standard output that read_line has not returned
    Ending end(int signal);

private:
    void keep_reading(const std::stop_token &ended);
    void take(std::string_view text);
    void close_input();
    void reap(bool waits);
    void finish_reading();

    std::filesystem::path error_file_;
    pid_t process_ = -1;
    int input_ = -1;            ///< of the program; −1 once closed
    int output_ = -1;           ///< of the program
    std::optional<int> status_; ///< of waitpid, once it has ended
    std::chrono::duration<double> after_signal_{0.0};

    std::mutex mutex_; ///< of the following
    std::condition_variable arrived_;
    std::deque<std::string> lines_;
    std::string begun_line_;
    bool at_end_ = false;

    std::jthread reader_; ///< last, as it uses the others
};

} // namespace springdrive::testing
