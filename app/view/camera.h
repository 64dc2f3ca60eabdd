// An orbit camera: looks at a target point from a distance, at a yaw and a pitch. World is the
// device frame in metres: x right, y up, z towards the user.
//
// A pixel is that of the window system: from the viewport's top left corner, y down. Any unit will
// do, of the framebuffer or of the mouse, as long as viewport and point share it.
#pragma once

#include "base/vector.h"

#include <glm/mat4x4.hpp>

#include <optional>

namespace springdrive::app {

struct PixelPoint {
    double x_px = 0.0;
    double y_px = 0.0;
};

struct PixelSize {
    double width_px = 0.0;
    double height_px = 0.0;

    [[nodiscard]] double aspect() const { return width_px / height_px; }
};

class Camera {
public:
    /// Looks at a box from the user's side, from above and a little to the right, as near as all
    /// of it is seen. @param aspect width/height of the viewport
    void frame(const Vector3 &lower_m, const Vector3 &upper_m, double aspect);

    /// Turns about the target, as if the scene were dragged by its near side.
    void orbit(double dx_px, double dy_px);
    /// Shifts the target in the view plane, so that what is at its depth follows the mouse.
    void pan(double dx_px, double dy_px, double viewport_height_px);
    /// Nearer by a tenth per step, farther for negative ones.
    void zoom(double steps);

    [[nodiscard]] glm::mat4 view() const;
    [[nodiscard]] glm::mat4 projection(double aspect) const;

    // Unit vectors, world.
    [[nodiscard]] Vector3 right() const;
    [[nodiscard]] Vector3 up() const;
    [[nodiscard]] Vector3 forward() const; ///< from the eye into the scene

    [[nodiscard]] Vector3 eye_m() const { return target_m_ - distance_m_ * forward(); }
    [[nodiscard]] const Vector3 &target_m() const { return target_m_; }
    [[nodiscard]] double distance_m() const { return distance_m_; } ///< from eye to target

    /// Size of a pixel in the view plane through `at_m`. Behind the eye, where a hand may be that
    /// is zoomed past, the same as in front of it.
    [[nodiscard]] double metres_per_pixel(const Vector3 &at_m, double viewport_height_px) const;

    /// The point seen at `pixel` that lies in the view plane through `at_m`.
    [[nodiscard]] Vector3 point_at(const PixelPoint &pixel, const PixelSize &viewport,
                                   const Vector3 &at_m) const;

    /// Where a point is seen; nothing when it is not in front of the eye.
    [[nodiscard]] std::optional<PixelPoint> pixel_of(const Vector3 &point_m,
                                                     const PixelSize &viewport) const;

private:
    /// Distance from the eye along `forward`.
    [[nodiscard]] double depth_m(const Vector3 &point_m) const {
        return (point_m - eye_m()).dot(forward());
    }

    Vector3 target_m_{Vector3::Zero()};
    double yaw_rad_ = 0.0;   ///< about y; 0 looks from +z, positive from the right
    double pitch_rad_ = 0.0; ///< positive looks from above
    double distance_m_ = 0.5;
    double framed_distance_m_ = 0.5; ///< of the last `frame`; zoom stays in proportion to it
};

} // namespace springdrive::app
