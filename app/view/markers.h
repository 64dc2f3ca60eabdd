// Markers in the view: tip, proxy, force, surface normal, hand target, and those that tell where
// the tip is in depth; without OpenGL.
//
// Balls and lines have a minimum size in pixels, so that they remain visible from a distance.
#pragma once

#include "app/view/camera.h"
#include "app/view/view_state.h"

#include <vector>

namespace springdrive::app {

/// During contact: the proxy, a thin dashed line from it along the surface normal, and a line to
/// the tip. The force arrow starts at the proxy, or at the tip without contact. The hand's target
/// is a ring with a cross that faces the camera. Each only if it is switched on.
[[nodiscard]] std::vector<Solid> marker_solids(const ViewState &state, const MarkerScale &scale);

/// The ball at the device's tip, separate because it is also visible through the other markers.
[[nodiscard]] Solid tip_solid(const ViewState &state, const MarkerScale &scale);

/// A thin line from the tip, or during contact from the proxy, straight down to what is below it,
/// and a ring that lies there. Nothing where it is as good as there, or
/// switched off.
[[nodiscard]] std::vector<Solid> height_line(const ViewState &state, const MarkerScale &scale);

/// The tip, and a ring about it that faces the camera, to be drawn where the scene hides it.
/// Nothing where the tip is switched off.
struct TipMarks {
    std::vector<Solid> tip;
    std::vector<Solid> ghost;
};
[[nodiscard]] TipMarks tip_marks(const ViewState &state, const MarkerScale &scale);

} // namespace springdrive::app
