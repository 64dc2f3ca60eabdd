// `springdrive figures`: the paper's figures, measured beside their predictions.
#pragma once

namespace CLI {
class App;
}

namespace springdrive::app {

/// Adds `figures` with its options to the command line; it runs when it is what was asked for.
void add_figures_command(CLI::App &app);

} // namespace springdrive::app
