// What follows from the active tuning: stiffness, damping, lag, added mass.
#pragma once

#include "engine/session/session.h"

namespace springdrive::app {

/// Static stiffness at the tip along a unit vector, of the coupling alone, with the dR that acts,
/// at the present configuration, on a rigid surface: (27) with the transpose map, nᵀ J⁻ᵀ K_q J⁻¹ n
/// (21) with the inverse map.
[[nodiscard]] double tip_stiffness_N_per_m(const session::Session &session, const Vector3 &along);

void show_consequences(const session::Session &session);

} // namespace springdrive::app
