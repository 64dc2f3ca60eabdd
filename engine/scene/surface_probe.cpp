#include "engine/scene/surface_probe.h"

#include "engine/contact/proxy/proxy.h"

#include <algorithm>

namespace springdrive::scene {

namespace {

/// Room left about a box for a tip to be free in.
constexpr double kRoom_m = 0.01;

/// A chord of 60° comes nearer to the middle than its ends by this factor, cos 30°.
constexpr double kNearestOfChord = 0.866;

} // namespace

SurfaceProbe::SurfaceProbe(const contact::HapticSurface &surface, const Eigen::AlignedBox3d &box,
                           double radius_m)
    : surface_(surface), box_(box), radius_m_(radius_m),
      far_m_((0.5 * box.diagonal().norm() + radius_m + kRoom_m) / kNearestOfChord) {}

std::optional<Vector3> SurfaceProbe::first_touch(const Vector3 &from_m, const Vector3 &to_m) const {
    contact::Proxy proxy(radius_m_);
    proxy.reset(from_m);
    static_cast<void>(proxy.update(surface_, to_m));
    // It goes straight until something stops it, and only then along the surface.
    if (proxy.path().size() < 2 || proxy.path()[1] == to_m) {
        return std::nullopt;
    }
    return proxy.path()[1];
}

std::optional<Vector3> SurfaceProbe::touch_from(const Vector3 &direction) const {
    return first_touch(outside(direction), middle_m());
}

} // namespace springdrive::scene
