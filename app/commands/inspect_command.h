// `springdrive inspect`: what a scene holds, and what of it can be touched.
#pragma once

namespace CLI {
class App;
}

namespace springdrive {

/// Adds `inspect` with its options to the command line; it runs when it is what was asked for.
void add_inspect_command(CLI::App &app);

} // namespace springdrive
