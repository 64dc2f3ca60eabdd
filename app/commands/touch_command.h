// `springdrive touch`: the proxy over a scene along a path, without window or device.
#pragma once

namespace CLI {
class App;
}

namespace springdrive::app {

/// Adds `touch` with its options to the command line; it runs when it is what was asked for.
void add_touch_command(CLI::App &app);

} // namespace springdrive::app
