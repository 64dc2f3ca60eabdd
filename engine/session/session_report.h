// Report on a completed run: the servo's timing, whether it was stopped, what was recorded.
#pragma once

#include "engine/session/session.h"

#include <iosfwd>

namespace springdrive::session {

/// A few lines of text.
void write_session_report(std::ostream &out, const Session &session);

/// The same figures as JSON: durations in seconds, units in all names.
void write_session_json(std::ostream &out, const Session &session);

/// Whether the safety monitor has stopped the device; if so, writes the cause to `errors`.
[[nodiscard]] bool was_stopped(const Session &session, std::ostream &errors);

/// Whether the record, if there was one, holds every tick; if not, writes the reason to
/// `errors`.
[[nodiscard]] bool record_is_whole(const Session &session, std::ostream &errors);

} // namespace springdrive::session
