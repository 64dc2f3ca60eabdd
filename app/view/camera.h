// An orbit camera: looks at a target point from a distance, at a yaw and a pitch. World is the
// device frame in metres: x right, y up, z towards the user.
//
// Pixels are in window coordinates: from the viewport's top left corner, y down. They may be those
// of the framebuffer or of the mouse, as long as viewport and point use the same unit.
#pragma once

#include "base/vector.h"

#include <glm/mat4x4.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <span>

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

struct MarkerScale {
    const Camera &camera;
    double viewport_height_px; ///< framebuffer
    double pixel_scale;        ///< framebuffer pixels per layout pixel

    /// The length that `layout_px` cover at a point.
    [[nodiscard]] double length_m(double layout_px, const Vector3 &at_m) const {
        return layout_px * pixel_scale * camera.metres_per_pixel(at_m, viewport_height_px);
    }
};

/// A part of a viewport, in its pixels.
struct PixelRectangle {
    PixelPoint top_left;
    PixelPoint bottom_right;
};

/// The camera at the smallest distance from which all points are seen within `part`, without
/// turning it. Where points lie behind each other, so that distance would be none, the eye stays
/// before the nearest one by a tenth of their extent in depth, and by 1 mm.
///
/// Along an axis a of the view, right or up, with t = offset from the optical axis per depth at the
/// borders of `part`, and p_a, p_f the coordinates of a point along a and along `forward`:
///
///   t_low ≤ (p_a − e_a)/(p_f − e_f) ≤ t_high   ⇔   p_a − t_high p_f ≤ e_a − t_high e_f  and
///                                                  p_a − t_low p_f ≥ e_a − t_low e_f
///
/// which has a solution e_a as long as
/// e_f ≤ (min(p_a − t_low p_f) − max(p_a − t_high p_f))/(t_high − t_low). The largest e_f that both
/// axes allow is taken, and along the axis that allows more the middle of what remains.
/// @pre there are points, all finite, and `part` has an extent in both directions
[[nodiscard]] Camera framed(Camera camera, std::span<const Vector3> points_m,
                            const PixelSize &viewport, const PixelRectangle &part);

[[nodiscard]] std::array<Vector3, 8> box_corners(const Vector3 &lower_m, const Vector3 &upper_m);

/// The smallest part of the viewport that contains the points in front of the eye.
[[nodiscard]] PixelRectangle drawn_part(const Camera &camera, std::span<const Vector3> points_m,
                                        const PixelSize &viewport);

} // namespace springdrive::app
