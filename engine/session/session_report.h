// What a run that ended by itself has to tell: how the servo kept its time, whether it was stopped,
// what was recorded.
#pragma once

#include "engine/session/session.h"

#include <iosfwd>

namespace springdrive::session {

/// A few lines for people.
void write_session_report(std::ostream &out, const Session &session);

/// The same figures for programs: durations in seconds, no unit left out.
void write_session_json(std::ostream &out, const Session &session);

/// Whether the safety monitor holds the device; says so on `complaints`, with the cause.
[[nodiscard]] bool was_stopped(const Session &session, std::ostream &complaints);

/// Whether the record, if there was one, holds every tick; if not, says on `complaints` why.
[[nodiscard]] bool record_is_whole(const Session &session, std::ostream &complaints);

} // namespace springdrive::session
