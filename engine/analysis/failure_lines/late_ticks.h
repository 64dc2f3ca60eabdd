// Stability of a servo whose every other tick is late, by eigenvalues.
//
//   tick      send                 tick late by k T   send          tick
//    A ─────── · · · · · · · · · ──── (A's) ── T ──── B ── (B's) ── T ─── A
//              k T behind what was sent before
//
// What a tick finds is sent with the next exchange. Where that comes late, the amplifiers hold what
// they had until then; and the way since the last tick is one of (1 + k) T.
#pragma once

#include "engine/analysis/stability/stability_case.h"

namespace springdrive {

/// The largest |eigenvalue| over two ticks.
/// @pre every position is pulled on, by law or hand; no delay beside
[[nodiscard]] double late_ticks_eigenvalue(const StabilityCase &which, const LoopMember &member,
                                           int missed);

} // namespace springdrive
