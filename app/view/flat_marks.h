// The flat marks of a touch: forces of both maps, contact plane, set-point, stiffness, trace,
// workspace; without OpenGL.
#pragma once

#include "app/view/flat_shapes.h"
#include "app/view/view_state.h"

#include <vector>

namespace springdrive::app {

/// What of these is switched on and there; three vertices a triangle.
[[nodiscard]] std::vector<FlatVertex> flat_marks(const ViewState &state, const MarkerScale &scale);

/// Ellipsoid and sphere of stiffness at the tip, see-through.
[[nodiscard]] std::vector<Solid> stiffness_bodies(const ViewState &state);

/// Their scale: 10 mm for 1 N/mm, less where the longest axis would exceed 60 mm [m per N/m].
[[nodiscard]] double stiffness_scale(const Matrix3 &inverse_N_per_m);

} // namespace springdrive::app
