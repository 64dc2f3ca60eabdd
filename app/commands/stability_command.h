// `springdrive stability`: whether a loop is stable, and where along one or two parameters it ends.
#pragma once

namespace CLI {
class App;
}

namespace springdrive::app {

/// Adds `stability` with its options to the command line; it runs when it is what was asked for.
void add_stability_command(CLI::App &app);

} // namespace springdrive::app
