// Files dragged from a file manager, by the protocol XDND, version 5.
#pragma once

#include "tests/support/virtual_display.h"

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace springdrive::testing {

/// As file managers write them: one file URI per line, with everything except letters, digits and
/// -._~/ percent-encoded.
/// @param paths  relative ones are meant from the folder of the test
[[nodiscard]] std::string uri_list(const std::vector<std::filesystem::path> &paths);

/// Plays the file manager: drags the files over the window and drops them at (x, y) of the screen.
/// Returns once the program has taken them.
/// @param window  the X11 window
/// @param settle  lets the program see what was done; empty for one that goes on by itself
/// @throw std::runtime_error  the window does not take files, or does not answer within 20 s
void drop_on_window(const VirtualDisplay &display, unsigned long window, int x, int y,
                    const std::vector<std::filesystem::path> &paths,
                    const std::function<void()> &settle);

} // namespace springdrive::testing
