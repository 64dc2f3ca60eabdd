// Controls of a simulated device beyond the interface of every device: the hand that holds it, and
// what is simulated.
#pragma once

#include "base/vector.h"
#include "device/simulated/hand_stimulus.h"
#include "device/simulated/simulation_options.h"

namespace springdrive::simulated {

class SimulatedWorld {
public:
    SimulatedWorld() = default;
    SimulatedWorld(const SimulatedWorld &) = delete;
    SimulatedWorld &operator=(const SimulatedWorld &) = delete;
    virtual ~SimulatedWorld() = default;

    /// Sets the hand's target from now on [m]; the hand moves there smoothly. One thread at a time,
    /// any thread; takes effect once the hand's path, if it has one, has ended.
    virtual void set_hand_target(const Vector3 &target_m) noexcept = 0;

    /// Starts a test signal of the hand, if its number is another one than before. One thread at a
    /// time, any thread.
    virtual void play(const HandStimulus &stimulus) noexcept = 0;

    /// From the next period on, uses the dynamics, effects, planar, longest_step_s, delay_periods
    /// and hand of `options`; all else is unchanged, and what the device reports of itself, too.
    /// Motors and linkage continue from their present state, so no encoder jumps. A moving base
    /// joint is not locked: planar takes effect only if it was on before. Stops that the linkage is
    /// beyond become active once it is back between them. One thread at a time, any thread.
    /// @throw InputError for options that are out of range or incompatible
    virtual void simulate_as(const SimulationOptions &options) = 0;

    // While no other thread uses the device:

    /// The hand follows this path from now on: its time 0 is now.
    virtual void follow(HandPath path) = 0;

    /// Where the hand's spring pulls to now, without a test signal [m].
    [[nodiscard]] virtual Vector3 hand_m() const = 0;
};

} // namespace springdrive::simulated
