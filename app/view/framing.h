// Where the camera stands so that everything is in the picture; without OpenGL.
#pragma once

#include "app/view/camera.h"
#include "app/view/solids.h"

#include <array>
#include <span>
#include <vector>

namespace springdrive::app {

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

/// Points whose convex hull contains all of the solids, as they are drawn.
[[nodiscard]] std::vector<Vector3> drawn_points(std::span<const Solid> solids);

/// The smallest part of the viewport that contains the points in front of the eye.
[[nodiscard]] PixelRectangle drawn_part(const Camera &camera, std::span<const Vector3> points_m,
                                        const PixelSize &viewport);

} // namespace springdrive::app
