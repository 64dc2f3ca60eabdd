// Stability found by trying: the nonlinear plant is let go beside rest, and what it does is
// watched.
#pragma once

#include "engine/lab/loops/stability_case.h"
#include "engine/lab/rig/law_rig.h"
#include "engine/lab/rig/ringdown.h"

namespace springdrive::limits {

/// What the simulation has beyond what the prediction knows.
struct SimulationEffects {
    bool quantisation = false; ///< of the encoders
    bool saturation = false;   ///< supply and peak current
    bool friction = false;     ///< Coulomb's

    [[nodiscard]] constexpr bool any() const { return quantisation || saturation || friction; }

    [[nodiscard]] static constexpr SimulationEffects none() { return {}; }
    /// What a device always has.
    [[nodiscard]] static constexpr SimulationEffects electronics() { return {true, true, false}; }
    [[nodiscard]] static constexpr SimulationEffects all() { return {true, true, true}; }
};

struct TrialOptions {
    SimulationEffects effects;
    double start_m = 1e-3;  ///< how far the tip is from where it rests when it is let go
    double longest_s = 3.0; ///< how long it is watched
    /// The same where it is not clear by then whether the motion dies out, see `RingdownOptions`.
    double patience_s = 0.0;

    /// Small motions without anything that the prediction does not know.
    [[nodiscard]] static constexpr TrialOptions linear() {
        return {SimulationEffects::none(), 1e-5, 3.0, 30.0};
    }
    /// A millimetre aside, as a tap would leave it.
    [[nodiscard]] static constexpr TrialOptions with(const SimulationEffects &effects) {
        return {effects, 1e-3, 3.0, 10.0};
    }
};

/// The law of a case, or the wall of its current drive, to be run in a rig.
[[nodiscard]] rig::LawOptions law_of(const loops::StabilityCase &which);

/// What came of it.
struct Trial {
    bool stable = true;
    bool stays = false;        ///< neither died out nor grew, as far as all patience could tell
    double growth_per_s = 0.0; ///< of the rates, at the end
    double last_rate_rad_per_s = 0.0; ///< the greatest of the last tenth of a second
};

/// One member's loop. With one motor that is `RotorSimulation`; with three the simulated PHANTOM
/// under the whole law, its tip tied to a point.
///
/// Stable is what comes to rest, or stays within two counts of the encoders to and fro for 0.4 s,
/// or for a period where oscillations are slow: a flicker of the last digits is not a motion that a
/// loop makes.
[[nodiscard]] Trial simulated(const loops::StabilityCase &which, const loops::LoopMember &member,
                              const TrialOptions &options);

/// Whether every member's motion dies out; ends with the first that does not.
[[nodiscard]] bool is_stable_simulated(const loops::StabilityCase &which,
                                       const TrialOptions &options);

} // namespace springdrive::limits
