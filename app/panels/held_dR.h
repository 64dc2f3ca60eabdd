// The active dR, where the winding guard or the observer of R holds it above what was requested.
#pragma once

#include "engine/session/session.h"

namespace springdrive::app {

/// The largest of the motors' active dR: at least the requested one.
[[nodiscard]] double active_dR_Ohm(const session::Session &session);

/// A checkbox to observe the windings' resistances, and what is known of them.
void draw_observed_resistances(session::Session &session);

/// Why dR is larger than requested, if it is.
void show_held_up_dR(const session::Session &session);

} // namespace springdrive::app
