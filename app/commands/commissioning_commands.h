// Subcommands of `device` for a device's first hour, and the board that they need.
#pragma once

#include "app/commands/command.h"
#include "app/commands/common_options.h"
#include "base/table.h"
#include "device/factory/device_factory.h"

#include <cstdint>
#include <filesystem>
#include <string>

namespace springdrive::app {

/// A board on USB, or an emulated one in this process.
struct TypedBoard {
    std::string device = "sim";
    std::filesystem::path device_file;
    std::uint64_t device_seed = 0;
    TypedEmulation emulation;
    bool is_at_zero = false;

    /// The options hold references to this: it must stay where it is until the parse is over.
    void add_to(Command &command);
    /// `--at-zero`. @param needed  ends its help
    void add_at_zero_to(Command &command, const std::string &needed);

    /// To drive nothing but the board's own test pulses.
    /// @throw InputError for options that do not fit the device, or a file that cannot be used
    [[nodiscard]] factory::BoardRequest request() const;
};

/// For a command that drives the motors: what the last session stored of the windings' temperatures
/// is wrong from now on, and removed. Zeroed if the device is in its zero pose, where the simulated
/// hand holds it, or a person as `--at-zero` says.
/// @throw InputError as `open_board` does
[[nodiscard]] factory::OpenBoard open_to_drive(const factory::BoardRequest &request,
                                               const TypedBoard &typed);

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
