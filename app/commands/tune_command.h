// `springdrive tune`: the stiffest tuning that every hand finds stable, as a file.
#pragma once

namespace CLI {
class App;
}

namespace springdrive::app {

/// Adds `tune` with its options to the command line; it runs when it is what was asked for.
void add_tune_command(CLI::App &app);

} // namespace springdrive::app
