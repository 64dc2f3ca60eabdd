// A touch without a user: over the scene, down into it, and in circles below its surface.
#pragma once

#include "device/core/device_file.h"
#include "device/simulated/hand_path.h"
#include "engine/contact/proxy/haptic_surface.h"

namespace springdrive::rig {

/// How the scripted hand moves.
struct ScriptedTouch {
    double wait_s = 1.2;         ///< at the start: the servo waits for rest, then raises its gains
    double approach_s = 0.8;     ///< from the start to above the surface, then into it
    double depth_m = 0.005;      ///< how far below the first contact it goes
    double speed_m_per_s = 0.06; ///< while sliding
    double duration_s = 60.0;
};

/// A path that presses into `mesh` from above, near the middle of its bounding box, and slides in
/// circles. Where nothing lies below, it circles over the middle of the box; where the device does
/// not reach there, it stays at the start.
[[nodiscard]] simulated::HandPath scripted_touch(const device::DeviceDescription &device,
                                                 const contact::HapticSurface &mesh,
                                                 const Vector3 &lower_m, const Vector3 &upper_m,
                                                 const Vector3 &start_m,
                                                 const ScriptedTouch &how = {});

/// A place in free space for a tip to start: just above the box, within the workspace.
[[nodiscard]] Vector3 start_above(const device::DeviceDescription &device, const Vector3 &lower_m,
                                  const Vector3 &upper_m);

} // namespace springdrive::rig
