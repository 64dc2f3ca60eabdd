// The quantities of a touch that can be drawn, beside those that always are.
#pragma once

#include "base/vector.h"

#include <memory>
#include <optional>
#include <vector>

namespace springdrive::app {

/// A place with a quantity there.
struct PlacedValue {
    Vector3 at_m{Vector3::Zero()};
    double value = 0.0;
};

/// A quantity all over the workspace.
struct WorkspaceField {
    std::vector<PlacedValue> places;
    double largest = 0.0; ///< of them
};

/// Each is there only if it is to be drawn.
struct TouchValues {
    std::optional<Vector3> inverse_force_N;
    std::optional<Vector3> transpose_force_N;
    std::optional<Vector3> set_point_m;
    std::optional<Matrix3> inverse_stiffness_N_per_m;
    std::optional<double> transpose_stiffness_N_per_m;
    std::vector<PlacedValue> trace_N; ///< the oldest first
    std::shared_ptr<const WorkspaceField> workspace;
};

/// The force at which the trace's colour ends.
inline constexpr double kTraceEnd_N = 3.0;

} // namespace springdrive::app
