// What the window tells the servo: one plain value, published whole through a mailbox.
#pragma once

#include "engine/contact/proxy/haptic_surface.h"
#include "engine/control/tuning.h"
#include "engine/servo/safety_limits.h"

#include <cstdint>

namespace springdrive::servo {

struct ServoInputs {
    control::Tuning tuning;
    SafetyLimits limits = unlowered(); ///< wishes to lower the device's; none raises one
    const contact::HapticSurface *surface =
        nullptr;                           ///< what can be touched; owned by the publisher
    std::uint32_t scene_id = 0;            ///< a change puts the proxy at the tip
    double global_alpha_rad2_per_m2 = 0.0; ///< for AlphaMode::global
    bool emergency_stop = false;           ///< trips the safety monitor while it is set
    std::uint32_t stop_count = 0;          ///< a change trips it too, even if a reset comes with it
    std::uint32_t reset_count = 0; ///< a change resets a tripped monitor, if its cause is gone
    bool release = false; ///< to let go of the device: gains fall, and stay down while it is set
    /// A window that lives changes it again and again; zero for whoever runs without one.
    std::uint32_t heartbeat = 0;
};

// The publisher must keep a surface alive until a ServoSample carries the scene_id of a later one.

} // namespace springdrive::servo
