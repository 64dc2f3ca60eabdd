// Subcommands of `device` for a device's first hour.
#pragma once

#include "app/commands/command.h"
#include "base/table.h"

#include <string>

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

/// Tells the person at the terminal what to do, once; nothing if it is empty.
/// @param said  the last one
/// @param hint  after it
void instruct(const std::string &instruction, const char *hint, std::string &said);

/// "2.1800 +- 0.0012"
[[nodiscard]] Cell with_deviation(int digits, double value, double deviation);

} // namespace springdrive::app
