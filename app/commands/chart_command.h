// `springdrive chart`: speed against accuracy of every method, in one run.
#pragma once

namespace CLI {
class App;
}

namespace springdrive::app {

/// Adds `chart` with its options to the command line; it runs when it is what was asked for.
void add_chart_command(CLI::App &app);

} // namespace springdrive::app
