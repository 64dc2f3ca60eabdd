// Markers in the view: tip, proxy, force, surface normal, hand target; without OpenGL.
//
// Balls and lines have a minimum size in pixels, so that they remain visible from a distance.
#pragma once

#include "app/view/camera.h"
#include "app/view/view_state.h"

#include <vector>

namespace springdrive::app {

struct MarkerScale {
    const Camera &camera;
    double viewport_height_px; ///< framebuffer
    double pixel_scale;        ///< framebuffer pixels per layout pixel

    /// The length that `layout_px` cover at a point.
    [[nodiscard]] double length_m(double layout_px, const Vector3 &at_m) const {
        return layout_px * pixel_scale * camera.metres_per_pixel(at_m, viewport_height_px);
    }
};

/// During contact: the proxy, a thin dashed line from it along the surface normal, and a line to
/// the tip. The force arrow starts at the proxy, or at the tip without contact. The hand's target
/// is a ring with a cross that faces the camera.
[[nodiscard]] std::vector<Solid> marker_solids(const ViewState &state, const MarkerScale &scale);

/// The ball at the device's tip, separate because it is also visible through the other markers.
[[nodiscard]] Solid tip_solid(const ViewState &state, const MarkerScale &scale);

} // namespace springdrive::app
