// The proxy (god-object): where the tip would be, had it not gone through the surface.
//
// Each tick it slides towards the tip: straight, until a facet stops it; then along the planes it
// has met, to the point nearest to the tip that they allow; and again from there with a clean
// slate, so that it comes over convex edges, until it rests. Every one of these motions is swept
// against the mesh, so whatever the tip does, the proxy's path crosses no surface.
#pragma once

#include "base/vector.h"
#include "engine/contact/contact.h"
#include "engine/contact/haptic_surface.h"

namespace springdrive {

class Proxy {
public:
    /// Starts free at the tip, on whichever side of the surface that is. A tip that is not finite
    /// is ignored.
    void reset(const Vector3 &tip_m) noexcept;

    /// Moves the proxy to the point nearest to the tip that it can reach without crossing the
    /// surface. RT-safe: bounded iterations, no allocation, lock, I/O or throw.
    ///
    /// A tip that is not finite, or a kilometre away, leaves the proxy where it is and makes the
    /// contact a free one; to stop the device is the safety monitor's part.
    Contact update(const HapticSurface &mesh, const Vector3 &tip_m) noexcept;

private:
    Vector3 position_m_{Vector3::Zero()};
};

} // namespace springdrive
