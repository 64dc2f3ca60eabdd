// The touch of a scene without anybody at it: where its surface is, where the tip starts, and how a
// scripted hand moves.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"
#include "device/core/hand_parameters.h"
#include "engine/contact/proxy/haptic_surface.h"

#include <Eigen/Geometry>

#include <optional>
#include <vector>

namespace springdrive::scene {

/// Finds a surface by probing it with the proxy.
class SurfaceProbe {
public:
    /// @param box       what the surface lies in
    /// @param radius_m  of the proxy, as for `Proxy`
    SurfaceProbe(const contact::HapticSurface &surface, const Eigen::AlignedBox3d &box,
                 double radius_m);

    /// Where a proxy that starts free and moves straight first touches, if it does.
    [[nodiscard]] std::optional<Vector3> first_touch(const Vector3 &from_m,
                                                     const Vector3 &to_m) const;

    /// The same for one that comes from far out towards the middle of the box.
    [[nodiscard]] std::optional<Vector3> touch_from(const Vector3 &direction) const;

    /// A place that is clear of the box, and so is the straight line to any other within 60°.
    [[nodiscard]] Vector3 outside(const Vector3 &direction) const {
        return middle_m() + far_m_ * direction;
    }

    [[nodiscard]] Vector3 middle_m() const { return box_.center(); }
    [[nodiscard]] const Eigen::AlignedBox3d &box() const { return box_; }

private:
    const contact::HapticSurface &surface_;
    Eigen::AlignedBox3d box_;
    double radius_m_;
    double far_m_;
};

/// A place in free space for a tip to start: just above the box, within the workspace.
[[nodiscard]] Vector3 start_above(const device::DeviceDescription &device, const Vector3 &lower_m,
                                  const Vector3 &upper_m);

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
/// not reach there, it stays at the start, which is `start_above` the box.
[[nodiscard]] std::vector<device::PathPoint>
scripted_touch(const device::DeviceDescription &device, const contact::HapticSurface &mesh,
               const Vector3 &lower_m, const Vector3 &upper_m, const ScriptedTouch &how = {});

} // namespace springdrive::scene
