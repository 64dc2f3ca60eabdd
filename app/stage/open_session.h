// Opens a session, with progress shown on a terminal.
#pragma once

#include "engine/session/session.h"

namespace springdrive::app {

/// Prints progress lines to standard error while its scene loads, if that takes long.
/// @throw InputError as Session's constructor does
[[nodiscard]] session::Session open_session(const session::SessionOptions &options);

/// Prints each warning once, to standard error.
void print_new_warnings(session::Session &session);

} // namespace springdrive::app
