// Controls of a simulated device beyond the interface of every device: the hand that holds it, and
// what is simulated.
#pragma once

#include "device/simulated/hand_control.h"
#include "device/simulated/simulation_options.h"

namespace springdrive::simulated {

class SimulatedWorld : public HandControl {
public:
    /// From the next period on, uses the dynamics, effects, planar, longest_step_s, delay_periods
    /// and hand of `options`; all else is unchanged, and what the device reports of itself, too.
    /// Motors and linkage continue from their present state, so no encoder jumps. A moving base
    /// joint is not locked: planar takes effect only if it was on before. Stops that the linkage is
    /// beyond become active once it is back between them. One thread at a time, any thread.
    /// @throw InputError for options that are out of range or incompatible
    virtual void simulate_as(const SimulationOptions &options) = 0;
};

} // namespace springdrive::simulated
