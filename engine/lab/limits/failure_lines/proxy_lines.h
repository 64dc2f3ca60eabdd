// Where the proxy fails, or was tried in vain.
#pragma once

#include "engine/lab/limits/failure_lines/failure_line.h"

namespace springdrive::limits {

/// Thin walls, fast tips, concave edges and corners, cracks, triangles without an area, and tips
/// that start inside.
[[nodiscard]] std::vector<TriedLine> proxy_lines();

} // namespace springdrive::limits
