// `springdrive stiffness`: the coupling K_θ over frequency, or how it softens as the motors warm.
#pragma once

namespace CLI {
class App;
}

namespace springdrive::app {

/// Adds `stiffness` with its options to the command line; it runs when it is what was asked for.
void add_stiffness_command(CLI::App &app);

} // namespace springdrive::app
