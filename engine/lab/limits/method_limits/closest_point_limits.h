// Where a penalty method fails, which uses the closest point of a mesh.
#pragma once

#include "engine/lab/limits/method_limits/method_limit.h"

namespace springdrive::limits {

/// Thin walls, fast tips and edges.
[[nodiscard]] std::vector<LimitTrial> closest_point_trials();

} // namespace springdrive::limits
