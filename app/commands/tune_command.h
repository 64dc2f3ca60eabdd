// `springdrive tune`: the stiffest tuning that every hand finds stable, as a file.
#pragma once

#include <iosfwd>

namespace CLI {
class App;
}

namespace springdrive::limits {
struct AutoTuned;
}

namespace springdrive::app {

/// What was found, its margins, and what is to be known about them, a line each.
void write_tuned(std::ostream &out, const limits::AutoTuned &found);

/// Adds `tune` with its options to the command line; it runs when it is what was asked for.
void add_tune_command(CLI::App &app);

} // namespace springdrive::app
