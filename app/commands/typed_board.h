// `--device` of commands that need a board, and what the emulated one is.
#pragma once

#include "app/commands/command.h"
#include "app/commands/common_options.h"
#include "device/factory/board_factory.h"

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

    /// The options hold references to this: it must stay where it is until the parse is over.
    void add_to(Command &command);

    /// To drive nothing but the board's own test pulses.
    /// @throw InputError for options that do not fit the device, or a file that cannot be used
    [[nodiscard]] factory::BoardRequest request() const;
};

/// For a command that drives the motors: what the last session stored of the windings' temperatures
/// is wrong from now on, and removed.
/// @throw InputError as `open_board` does
[[nodiscard]] factory::OpenBoard open_to_drive(const factory::BoardRequest &request);

} // namespace springdrive::app
