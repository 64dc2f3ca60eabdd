// `springdrive baseline`: the spring drive against a current drive, each at its stable best.
#pragma once

namespace CLI {
class App;
}

namespace springdrive::app {

/// Adds `baseline` with its options to the command line; it runs when it is what was asked for.
void add_baseline_command(CLI::App &app);

} // namespace springdrive::app
