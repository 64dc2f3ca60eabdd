// The PHANTOM as solid bars and joints, built from its kinematics; without OpenGL.
#pragma once

#include "app/view/view_state.h"

#include <cstdint>
#include <vector>

namespace springdrive::app {

/// What moves as one. The base turns about the vertical, too, but looks the same then but for its
/// motors.
enum class LinkagePart : std::uint8_t { base, upper_arm, crank, rod, forearm };

struct LinkageSolid {
    LinkagePart part = LinkagePart::base;
    Solid solid;
};

/// Plate, hub, column and motors of the base, upper arm, crank, rod, and the forearm, tapered
/// towards the tip. Parts that share a joint meet about its axis; otherwise none passes through
/// another. Red when tripped.
[[nodiscard]] std::vector<LinkageSolid> linkage_parts(const device::LinkagePose &pose,
                                                      double floor_height_m, bool tripped);

/// The same without their parts.
[[nodiscard]] std::vector<Solid> linkage_solids(const device::LinkagePose &pose,
                                                double floor_height_m, bool tripped);

} // namespace springdrive::app
