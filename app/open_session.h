// A session for those who wait before a terminal.
#pragma once

#include "engine/session/session.h"

namespace springdrive {

/// With lines on standard error while its scene loads, if that takes long.
/// @throw InputError as Session's constructor does
[[nodiscard]] Session open_session(const SessionOptions &options);

/// On standard error, each once.
void print_new_remarks(Session &session);

} // namespace springdrive
