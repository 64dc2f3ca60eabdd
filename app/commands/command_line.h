// Parses the command line and runs a subcommand; and the manual page and the completion for bash,
// which are written from its tree when the program is built: they name what it accepts, and nothing
// else.
#pragma once

#include <iosfwd>
#include <memory>

namespace CLI {
class App;
}

namespace springdrive::app {

/// All subcommands with their options and texts; it runs what it parses.
[[nodiscard]] std::unique_ptr<CLI::App> command_tree();

/// Parses the command line and runs the subcommand that it names, by default `demo`.
/// @return the exit status: 0, 2 for invalid options, printed as one line, or the status of a
///         command that gives a verdict
/// @throw InputError for a file or value that parses but cannot be used.
[[nodiscard]] int run_command_line(int argc, char **argv);

/// springdrive(1), in the format of man(7).
void write_manual(std::ostream &out, const CLI::App &program);

/// A script for bash, which needs no other.
void write_bash_completion(std::ostream &out, const CLI::App &program);

} // namespace springdrive::app
