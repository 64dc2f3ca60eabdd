// `springdrive inspect`: what a scene holds, what of it can be touched, and which model it gets.
#pragma once

namespace CLI {
class App;
}

namespace springdrive::app {

/// Adds `inspect` with its options to the command line; it runs when it is what was asked for.
void add_inspect_command(CLI::App &app);

} // namespace springdrive::app
