// Parses the command line and runs a subcommand.
#pragma once

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

} // namespace springdrive::app
