// Where the proxy fails, or was tried without a failure.
#pragma once

#include "engine/lab/limits/method_limits/method_limit.h"

namespace springdrive::limits {

/// Thin walls, fast tips, concave edges and corners, cracks, degenerate triangles, and tips that
/// start inside.
[[nodiscard]] std::vector<LimitTrial> proxy_trials();

} // namespace springdrive::limits
