// A session for those who wait before a terminal.
#pragma once

#include "engine/session/session.h"

namespace springdrive::app {

/// With lines on standard error while its scene loads, if that takes long.
/// @throw InputError as Session's constructor does
[[nodiscard]] session::Session open_session(const session::SessionOptions &options);

/// On standard error, each once.
void print_new_remarks(session::Session &session);

} // namespace springdrive::app
