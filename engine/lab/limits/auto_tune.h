// The stiffest tuning that every hand finds stable, with something in hand.
//
// Given device, servo rate, delay and dR, K_DC (13) goes with K_P alone. So: the largest K_P, over
// all K_D and λ, for which every loop of `HeldLoops` is stable even with K_P and K_D a margin
// larger. Each pair of K_D and λ has a largest K_P, by bisection; a grid of pairs, then ever closer
// ones about the best, find the top. Where encoder counts keep that one rattling, K_P is taken
// back.
#pragma once

#include "engine/control/tuning_file.h"
#include "engine/lab/loops/held_loops.h"

#include <functional>

namespace springdrive::limits {

struct AutoTuneRequest {
    loops::StabilityCase which; ///< of its tuning, dR, the map and where α comes from are kept
    double margin = 1.3;        ///< by what factor K_P and K_D might be larger yet; at least 1
    double greatest_K_P_V_per_rad = 20.0; ///< that of tuning files and panels
};

struct AutoTuned {
    control::Tuning tuning; ///< with η = 0
    control::TuningMargins margins;
    std::size_t loops = 0; ///< that are all stable
    /// The share of K_P that was taken back, since a trial with counts and supply did not rest.
    double taken_back = 0.0;
};

/// @param progress  told a share from 0 to 1; returns false to give up
/// @throw InputError where no tuning at all is stable, or `progress` gave up; for a margin or a
/// case
///        that cannot be
[[nodiscard]] AutoTuned auto_tune(
    const AutoTuneRequest &request,
    const std::function<bool(double)> &progress = [](double) { return true; });

} // namespace springdrive::limits
