// What the window tells the servo: one plain value, published whole through a mailbox.
#pragma once

#include "engine/contact/haptic_surface.h"
#include "engine/control/tuning.h"

#include <cstdint>

namespace springdrive {

struct ServoInputs {
    Tuning tuning;
    const HapticSurface *mesh = nullptr; ///< what can be touched; owned by the publisher, see below
    std::uint32_t scene_id = 0;          ///< a change puts the proxy at the tip
    double global_alpha_rad2_per_m2 = 0.0; ///< for AlphaMode::global
    bool emergency_stop = false;           ///< trips the safety monitor while it is set
    std::uint32_t reset_count = 0; ///< a change resets a tripped monitor, if its cause is gone
};

// The publisher must keep a mesh alive until a ServoSample carries the scene_id of a later one.

} // namespace springdrive
