// A hand that explores a scene from above, pressing and letting go: what models of it are compared
// on.
#pragma once

#include "device/core/device_description.h"
#include "device/simulated/hand_path.h"
#include "engine/contact/proxy/haptic_surface.h"

#include <Eigen/Geometry>

namespace springdrive::rig {

/// How it moves.
struct Exploration {
    double rest_s = 0.05;        ///< at the start
    double approach_s = 0.25;    ///< from the start into the surface
    double duration_s = 2.0;     ///< in all
    double speed_m_per_s = 0.08; ///< along the path seen from above
    double min_depth_m = -0.001; ///< below the surface, straight down: it leaves contact,
    double max_depth_m = 0.007;  ///< returns and presses in, repeatedly,
    double press_hz = 3.0;       ///< at this frequency
    double climb_m_per_s = 0.15; ///< maximum vertical speed: it runs into a wall before it rises
                                 ///< over it
    bool planar = false;         ///< stays in the plane of its start, x = const
};

/// Its path over what `box` holds, begun at `start_m`: a Lissajous figure seen from above over the
/// middle 70 % of the box, or over as much of that as the device reaches. Where nothing lies below,
/// it keeps to the height of the box's floor; where the device reaches nothing, it stays.
[[nodiscard]] simulated::HandPath exploration_path(const device::DeviceDescription &device,
                                                   const contact::HapticSurface &surface,
                                                   const Eigen::AlignedBox3d &box,
                                                   const Vector3 &start_m,
                                                   const Exploration &how = {});

} // namespace springdrive::rig
