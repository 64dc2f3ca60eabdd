// Finds a surface by probing it with the proxy.
#pragma once

#include "base/vector.h"
#include "engine/contact/proxy/haptic_surface.h"

#include <Eigen/Geometry>

#include <optional>

namespace springdrive::scene {

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

} // namespace springdrive::scene
