// How large marks are that keep a size in pixels.
#pragma once

#include "app/view/camera.h"

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

} // namespace springdrive::app
