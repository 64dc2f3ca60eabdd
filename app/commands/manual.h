// The manual page, and the completion for bash. Both are written from the tree of the command line,
// when the program is built: they name what it accepts, and nothing else.
#pragma once

#include <iosfwd>

namespace CLI {
class App;
}

namespace springdrive::app {

/// springdrive(1), in the format of man(7).
void write_manual(std::ostream &out, const CLI::App &program);

/// A script for bash, which needs no other.
void write_bash_completion(std::ostream &out, const CLI::App &program);

} // namespace springdrive::app
