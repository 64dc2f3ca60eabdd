// Subcommands of `device` for a device's first hour.
#pragma once

namespace CLI {
class App;
} // namespace CLI

namespace springdrive::app {

/// `device info`: what a board says of itself.
void add_info(CLI::App &device);

/// `device self-test`.
void add_self_test(CLI::App &device);

/// `device sweep`: the rendered stiffness by sine sweep.
void add_sweep(CLI::App &device);

/// `device calibrate`.
void add_calibrate(CLI::App &device);

/// Whether a line was typed since the last call; does not wait.
[[nodiscard]] bool has_typed_line();

} // namespace springdrive::app
