// Stability of a servo whose every other tick is late, by eigenvalues.
//
//   tick                        tick, late by k T      tick
//    A ─────── A's, (1 + k) T ───── B ── B's, T ──────── A
//
// The amplifiers hold what a tick found until the next one, which sees the way since then as one of
// (1 + k) T.
#pragma once

#include "engine/lab/loops/stability_case.h"

namespace springdrive::limits {

/// The largest |eigenvalue| over two ticks.
/// @pre every position is pulled on, by law or hand; no delay beside
[[nodiscard]] double late_ticks_eigenvalue(const loops::StabilityCase &which,
                                           const loops::LoopMember &member, int missed);

} // namespace springdrive::limits
