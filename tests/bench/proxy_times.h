// How long the proxy's updates take along a path of the tip.
#pragma once

#include "base/vector.h"
#include "engine/contact/proxy/haptic_surface.h"

#include <vector>

namespace springdrive::bench {

struct ProxyTimes {
    std::vector<double> floor_ns; ///< each update's minimum of all repeats
    std::vector<double> raw_ns;   ///< of every update of every repeat
    double touching = 0.0;        ///< share of updates in contact
};

/// Follows the path `kRepeats` times, each time with a new proxy and identical results. The step to
/// the first tip is not timed.
[[nodiscard]] ProxyTimes time_proxy(const contact::HapticSurface &surface,
                                    const std::vector<Vector3> &tips_m);

/// The same once, with 96 MB of other memory swept before each update, so that the surface is in no
/// cache [ns].
[[nodiscard]] std::vector<double> time_proxy_cold(const contact::HapticSurface &surface,
                                                  const std::vector<Vector3> &tips_m);

} // namespace springdrive::bench
