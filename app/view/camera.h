// An orbit camera: looks at a target point from a distance, at a yaw and a pitch. World is the
// device frame in metres: x right, y up, z towards the user.
//
// Pixels are in window coordinates: from the viewport's top left corner, y down. They may be those
// of the framebuffer or of the mouse, as long as viewport and point use the same unit.
#pragma once

#include "base/vector.h"

#include <glm/mat4x4.hpp>

#include <cstdint>
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
    [[nodiscard]] bool operator==(const PixelSize &) const = default;
};

/// Directions to look from.
enum class Viewpoint : std::uint8_t {
    home,  ///< from the user's side, from above and slightly from the right
    top,   ///< from above, the user below
    front, ///< from the user's side, level
};

class Camera {
public:
    /// Turns about the target.
    void look_from(Viewpoint viewpoint);

    /// Moves eye and target without turning; limits of the zoom are relative to this distance.
    /// @pre distance_m > 0
    void place(const Vector3 &eye_m, double distance_m);

    /// Rotates about the target, so that the near side of the scene follows the mouse.
    void orbit(double dx_px, double dy_px);
    /// Shifts the target in the view plane, so that points at its depth follow the mouse.
    void pan(double dx_px, double dy_px, double viewport_height_px);
    /// Moves nearer to a point by a tenth per step, farther for negative steps; the point stays at
    /// its pixel.
    void zoom(double steps, const Vector3 &about_m);

    [[nodiscard]] glm::mat4 view() const;
    [[nodiscard]] glm::mat4 projection(double aspect) const;

    // Unit vectors, world.
    [[nodiscard]] Vector3 right() const;
    [[nodiscard]] Vector3 up() const;
    [[nodiscard]] Vector3 forward() const; ///< from the eye into the scene

    [[nodiscard]] Vector3 eye_m() const { return target_m_ - distance_m_ * forward(); }
    [[nodiscard]] const Vector3 &target_m() const { return target_m_; }
    [[nodiscard]] double distance_m() const { return distance_m_; } ///< from eye to target

    /// Height of half the viewport in a view plane, per distance of that plane from the eye.
    [[nodiscard]] static double half_height_per_depth();

    /// Size of a pixel in the view plane through `at_m`. It is symmetric about the eye, as zooming
    /// can put the hand behind it.
    [[nodiscard]] double metres_per_pixel(const Vector3 &at_m, double viewport_height_px) const;

    /// The point at `pixel` in the view plane through `at_m`.
    [[nodiscard]] Vector3 point_at(const PixelPoint &pixel, const PixelSize &viewport,
                                   const Vector3 &at_m) const;

    /// The pixel of a point; nothing if it is not in front of the eye.
    [[nodiscard]] std::optional<PixelPoint> pixel_of(const Vector3 &point_m,
                                                     const PixelSize &viewport) const;

    [[nodiscard]] bool operator==(const Camera &) const = default;

private:
    /// Distance from the eye along `forward`.
    [[nodiscard]] double depth_m(const Vector3 &point_m) const {
        return (point_m - eye_m()).dot(forward());
    }

    Vector3 target_m_{Vector3::Zero()};
    double yaw_rad_ = 0.0;   ///< about y; 0 looks from +z, positive from the right
    double pitch_rad_ = 0.0; ///< positive looks from above
    double distance_m_ = 0.5;
    double framed_distance_m_ = 0.5; ///< of the last `place`; limits of the zoom are relative to it
};

} // namespace springdrive::app
