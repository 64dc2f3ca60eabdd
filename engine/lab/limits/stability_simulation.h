// Stability found by trials: the nonlinear plant is released near rest and its motion recorded.
#pragma once

#include "engine/lab/loops/stability_case.h"
#include "engine/lab/rig/law_rig.h"
#include "engine/lab/rig/ringdown.h"
#include "engine/lab/rig/scenario/scenarios.h"

#include <cmath>

namespace springdrive::limits {

/// Effects of the simulation that the prediction does not include.
struct SimulationEffects {
    bool quantisation = false; ///< of the encoders
    bool saturation = false;   ///< supply and peak current
    bool friction = false;     ///< Coulomb's

    [[nodiscard]] constexpr bool any() const { return quantisation || saturation || friction; }

    [[nodiscard]] static constexpr SimulationEffects none() { return {}; }
    /// The effects that a device always has.
    [[nodiscard]] static constexpr SimulationEffects electronics() { return {true, true, false}; }
    [[nodiscard]] static constexpr SimulationEffects all() { return {true, true, true}; }
};

struct TrialOptions {
    SimulationEffects effects;
    double start_m = 1e-3;  ///< initial distance of the tip from its place of rest
    double longest_s = 3.0; ///< how long it is observed
    /// The same where it is still undecided by then whether the motion decays, see
    /// `RingdownOptions`.
    double extension_s = 0.0;

    /// Small motions, only with effects that the prediction includes.
    [[nodiscard]] static constexpr TrialOptions linear() {
        return {SimulationEffects::none(), 1e-5, 3.0, 30.0};
    }
    /// A millimetre from rest, as after a tap.
    [[nodiscard]] static constexpr TrialOptions with(const SimulationEffects &effects) {
        return {effects, 1e-3, 3.0, 10.0};
    }
};

/// The law of a case, or the wall of its current drive, for a rig.
[[nodiscard]] rig::LawOptions law_of(const loops::StabilityCase &which);

/// Device, tuning, configuration, period and delay of a case, to make a scenario of.
[[nodiscard]] rig::ScenarioSetting setting_of(const loops::StabilityCase &which);

/// A hand of a case, for simulation. @param max_force_N  of its spring; unlimited by default
[[nodiscard]] device::HandParameters simulated_hand(const loops::Hand &hand,
                                                    double max_force_N = HUGE_VAL);

/// The result of a trial.
struct Trial {
    bool stable = true;
    bool stays = false;               ///< neither decayed nor grew within the whole observation
    double growth_per_s = 0.0;        ///< of the rates, at the end
    double last_rate_rad_per_s = 0.0; ///< the maximum of the last tenth of a second
};

/// One member's loop. With one motor that is `RotorSimulation`, on rigid links whatever the
/// member's structure; with three the simulated PHANTOM under the whole law, its tip tied to a
/// point, with that structure.
///
/// Stable means that it comes to rest, or stays within two encoder counts for 0.4 s, or for a
/// period where oscillations are slow: chatter between adjacent counts is not an instability of the
/// loop.
[[nodiscard]] Trial simulated(const loops::StabilityCase &which, const loops::LoopMember &member,
                              const TrialOptions &options);

/// The case that trials have: one motor alone is on rigid links.
[[nodiscard]] loops::StabilityCase as_tried(const loops::StabilityCase &which);

/// Whether the motion of every member of that decays; stops at the first that does not.
[[nodiscard]] bool is_stable_simulated(const loops::StabilityCase &which,
                                       const TrialOptions &options);

} // namespace springdrive::limits
