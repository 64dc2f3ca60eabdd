// The program that follows from what was typed.
#pragma once

namespace springdrive::app {

/// Parses the command line and runs the subcommand that it names, `demo` where it names none.
/// @return the exit status: 0, 2 for a mistake in the options, printed as one line, or what a
///         command says that was asked for a verdict
/// @throw InputError for a file or value that parses but cannot be used.
[[nodiscard]] int run_command_line(int argc, char **argv);

} // namespace springdrive::app
