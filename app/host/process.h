// Signals that request termination (SIGINT, SIGTERM, SIGHUP) only set a flag, which loops poll; and
// another program that is run to its end.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace springdrive::app {

/// Installs the handlers of these signals, but leaves SIGHUP ignored, as nohup has it.
void note_ending_signals();

[[nodiscard]] bool asked_to_end();

enum class ProgramStream { output, error };

struct ProgramEnding {
    int spawn_error = 0; ///< an errno, if it could not be started
    int wait_status = 0; ///< of waitpid
    std::string text;    ///< what it wrote to the stream that was asked for
};

/// Waits for the program's end. It gets no standard input; the stream that is not asked for goes to
/// /dev/null (output) or remains ours (error). No shell is involved. Does not fork, which would
/// burden a servo in this process with page faults.
/// @param arguments  the first is the program, looked up in PATH
[[nodiscard]] ProgramEnding run_program(std::vector<std::string> arguments,
                                        const std::filesystem::path &folder, ProgramStream stream);

} // namespace springdrive::app
