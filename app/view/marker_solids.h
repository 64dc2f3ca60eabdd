// What marks the haptics in the view: tip, proxy, force, surface normal, hand target; no OpenGL.
//
// Balls and lines have a least size in pixels, so that they stay legible from afar.
#pragma once

#include "app/view/camera.h"
#include "app/view/view_state.h"

#include <vector>

namespace springdrive::app {

struct MarkerScale {
    const Camera &camera;
    double viewport_height_px; ///< framebuffer
    double pixel_scale;        ///< framebuffer pixels in a pixel of the layout

    /// The length that `layout_px` cover at a point.
    [[nodiscard]] double length_m(double layout_px, const Vector3 &at_m) const {
        return layout_px * pixel_scale * camera.metres_per_pixel(at_m, viewport_height_px);
    }
};

/// While touching: proxy and, from it, a thin dashed line along the surface normal and a line to
/// the tip. The force arrow starts at the proxy, or at the tip while there is none. The hand's
/// target is a ring with a cross that faces the camera.
[[nodiscard]] std::vector<Solid> marker_solids(const ViewState &state, const MarkerScale &scale);

/// The ball at the device's tip, apart from the others as it shows through them too.
[[nodiscard]] Solid tip_solid(const ViewState &state, const MarkerScale &scale);

} // namespace springdrive::app
