// Stability of a servo with every other tick late, by eigenvalues.
//
//   tick                        tick, late by k T      tick
//    A ─────── A's, (1 + k) T ───── B ── B's, T ──────── A
//
// The amplifiers hold a tick's command until the next one, which takes the time since then
// as (1 + k) T.
#pragma once

#include "engine/lab/loops/stability_case.h"

namespace springdrive::limits {

/// The largest |eigenvalue| over two ticks.
/// @pre law or hand pull on every position; no other delay
[[nodiscard]] double late_ticks_eigenvalue(const loops::StabilityCase &which,
                                           const loops::LoopMember &member, int missed);

} // namespace springdrive::limits
