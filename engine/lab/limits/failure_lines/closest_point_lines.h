// Where a penalty method fails, which uses the closest point of a mesh.
#pragma once

#include "engine/lab/limits/failure_lines/failure_line.h"

namespace springdrive::limits {

/// Thin walls, fast tips and edges.
[[nodiscard]] std::vector<TriedLine> closest_point_lines();

} // namespace springdrive::limits
