// What only a simulated device has, beside the interface that every device has: a world around it,
// which can be told what to do.
#pragma once

#include "base/vector.h"
#include "device/simulated/simulation_options.h"

namespace springdrive::simulated {

class SimulatedWorld {
public:
    SimulatedWorld() = default;
    SimulatedWorld(const SimulatedWorld &) = delete;
    SimulatedWorld &operator=(const SimulatedWorld &) = delete;
    virtual ~SimulatedWorld() = default;

    /// Where the hand wants to be from now on [m]. One thread at a time, any thread; without
    /// effect while the hand follows a path. The hand moves there smoothly.
    virtual void set_hand_target(const Vector3 &target_m) noexcept = 0;

    /// Simulates from the next period on as much as `options` say by their dynamics, effects,
    /// planar and longest_step_s; all else stays as it was. Motors and linkage go on from where
    /// they are, so no encoder jumps. A base joint that moves is not seized: planar holds only
    /// where it held before. Stops that the linkage is beyond begin to press once it is back
    /// between them. One thread at a time, any thread.
    /// @throw InputError for options out of range or that do not go together
    virtual void simulate_as(const SimulationOptions &options) = 0;
};

} // namespace springdrive::simulated
