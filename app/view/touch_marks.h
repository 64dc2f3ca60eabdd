// Marks that tell where the tip is in depth; without OpenGL.
#pragma once

#include "app/view/marker_solids.h"

#include <vector>

namespace springdrive::app {

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
