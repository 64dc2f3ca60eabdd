// What follows from the active tuning: stiffness, damping, lag, added mass; and the active dR,
// where the winding guard or the observer of R holds it above what was requested.
#pragma once

#include "engine/session/session.h"

namespace springdrive::app {

/// The largest of the motors' active dR: at least the requested one.
[[nodiscard]] double active_dR_Ohm(const session::Session &session);

/// A checkbox to observe the windings' resistances, and what is known of them.
void draw_observed_resistances(session::Session &session);

/// Why dR is larger than requested, if it is.
void show_held_up_dR(const session::Session &session);

/// Static stiffness at the tip along a unit vector, of the coupling alone, with the dR that acts,
/// at the present configuration, on a rigid surface: (27) with the transpose map, nᵀ J⁻ᵀ K_q J⁻¹ n
/// (21) with the inverse map.
[[nodiscard]] double tip_stiffness_N_per_m(const session::Session &session, const Vector3 &along);

void show_consequences(const session::Session &session);

} // namespace springdrive::app
