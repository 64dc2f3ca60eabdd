// Subcommands of `device` for a device's first hour.
#pragma once

#include "app/commands/command.h"

namespace springdrive::app {

/// `device info`: what a board says of itself.
void add_info(Command &device);

/// `device self-test`.
void add_self_test(Command &device);

/// `device sweep`: the rendered stiffness by sine sweep.
void add_sweep(Command &device);

/// `device calibrate`.
void add_calibrate(Command &device);

/// Whether a line was typed since the last call; does not wait.
[[nodiscard]] bool has_typed_line();

} // namespace springdrive::app
