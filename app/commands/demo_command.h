// `springdrive demo`: the window.
#pragma once

namespace CLI {
class App;
}

namespace springdrive::app {

/// Adds `demo` with its options to the command line; it runs when it is what was asked for.
void add_demo_command(CLI::App &app);

} // namespace springdrive::app
