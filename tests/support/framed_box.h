// A camera that shows a box from the home viewpoint.
#pragma once

#include "app/view/camera.h"

namespace springdrive::testing {

/// All of the box is in the viewport, and touches its border.
inline app::Camera framed_box(const Vector3 &lower_m, const Vector3 &upper_m,
                              const app::PixelSize &viewport) {
    app::Camera camera;
    camera.look_from(app::Viewpoint::home);
    return app::framed(camera, app::box_corners(lower_m, upper_m), viewport,
                       {{0.0, 0.0}, {viewport.width_px, viewport.height_px}});
}

} // namespace springdrive::testing
