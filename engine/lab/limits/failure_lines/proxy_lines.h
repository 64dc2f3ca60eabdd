// Where the proxy fails, or was tried without a failure.
#pragma once

#include "engine/lab/limits/failure_lines/failure_line.h"

namespace springdrive::limits {

/// Thin walls, fast tips, concave edges and corners, cracks, degenerate triangles, and tips that
/// start inside.
[[nodiscard]] std::vector<TriedLine> proxy_lines();

} // namespace springdrive::limits
