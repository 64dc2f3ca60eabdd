// The stiffest tuning that is stable with every hand, with a margin.
//
// With device, servo rate, delay and dR given, K_DC (13) is proportional to K_P. The result is
// therefore the largest K_P, over all K_D and λ, for which every loop of `TuningConstraints` is
// stable even with K_P and K_D larger by the margin, and whose coupling is passive if asked for.
// For each pair of K_D and λ the largest K_P is found by bisection; a grid of pairs, then ever
// finer ones around the best, give the maximum. Where encoder counts keep that tuning vibrating,
// K_P is reduced.
#pragma once

#include "engine/control/tuning_file.h"
#include "engine/lab/loops/tuning_constraints.h"

#include <functional>
#include <string>

namespace springdrive::limits {

struct AutoTuneRequest {
    loops::StabilityCase which; ///< of its tuning, dR, the map and the source of α are kept
    double margin = 1.3;        ///< the factor by which K_P and K_D could be larger; at least 1
    bool is_passive = false;    ///< whether it must be, with kPassiveMargin
    /// By default the limit of tuning files and panels.
    double max_K_P_V_per_rad = control::parameter_of(&control::Tuning::K_P_V_per_rad).maximum;
};

/// By this factor K_P and K_D of a passive tuning could be larger until it is active in contact. In
/// free space, where no gain enters, λ has none.
inline constexpr double kPassiveMargin = 1.0 / 0.9;

struct AutoTuned {
    control::Tuning tuning; ///< with η = 0
    control::TuningMargins margins;
    std::size_t loops = 0; ///< how many loops were checked; all are stable
    /// The factor by which K_P and K_D may rise with the device's compliance in cables, links or
    /// both, in rigid contact at the case's configuration; below 1 they are unstable there.
    double gain_with_structure = 0.0;
    std::string coupling; ///< "passive", or what is known of it, see `loops::port_text`
    /// The share by which K_P was reduced because a trial with counts and supply did not come to
    /// rest.
    double taken_back = 0.0;
};

/// @param progress  receives a share from 0 to 1; returns false to cancel
/// @throw InputError where no tuning is stable or comes to rest, `progress` cancels, or the margin
///        is out of range
[[nodiscard]] AutoTuned auto_tune(
    const AutoTuneRequest &request,
    const std::function<bool(double)> &progress = [](double) { return true; });

} // namespace springdrive::limits
