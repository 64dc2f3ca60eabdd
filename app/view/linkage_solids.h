// The PHANTOM as solid bars and joints, built from its kinematics; without OpenGL.
#pragma once

#include "app/view/view_state.h"

#include <vector>

namespace springdrive::app {

/// Base hub on the floor, turret, upper arm, crank, coupling bar, and the forearm, tapered towards
/// the tip. Red when tripped.
[[nodiscard]] std::vector<Solid> linkage_solids(const device::LinkagePose &pose,
                                                double floor_height_m, bool tripped);

} // namespace springdrive::app
