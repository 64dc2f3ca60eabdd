// What is drawn of a touch, without OpenGL: markers, which are solids (tip, proxy, force, surface
// normal, hand target, and those that tell where the tip is in depth), and flat marks as triangles
// (forces of both maps, contact plane, set-point, stiffness, trace, workspace). Many flat marks are
// drawn at once, which one solid each would not allow.
//
// Balls and lines have a minimum size in pixels, so that they remain visible from a distance.
#pragma once

#include "app/view/camera.h"
#include "app/view/solids.h"
#include "app/view/view_state.h"

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <utility>
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

struct FlatVertex {
    glm::vec3 position_m;
    glm::vec4 colour; ///< sRGB, straight alpha
};

/// Appends triangles that face the camera, unless said otherwise.
class FlatShapes {
public:
    explicit FlatShapes(const MarkerScale &scale) : scale_(scale) {}

    void line(const Vector3 &from_m, const Vector3 &to_m, double width_px, const Colour &from,
              const Colour &to, float alpha = 1.0F);
    void line(const Vector3 &from_m, const Vector3 &to_m, double width_px, const Colour &colour,
              float alpha = 1.0F) {
        line(from_m, to_m, width_px, colour, colour, alpha);
    }

    /// An ellipse's outline: centre + a cos + b sin.
    void ellipse(const Vector3 &centre_m, const Vector3 &a_m, const Vector3 &b_m, double width_px,
                 const Colour &colour, float alpha = 1.0F);

    /// The area within it.
    void disc(const Vector3 &centre_m, const Vector3 &a_m, const Vector3 &b_m, const Colour &colour,
              float alpha);

    /// A shaft with a head. @pre along_m is not zero
    void arrow(const Vector3 &from_m, const Vector3 &along_m, double width_px, const Colour &colour,
               float alpha = 1.0F);

    /// A square on its corner.
    void dot(const Vector3 &centre_m, double radius_m, const Colour &colour, float alpha = 1.0F);

    [[nodiscard]] std::vector<FlatVertex> take() { return std::move(vertices_); }

private:
    void triangle(const Vector3 &a_m, const Vector3 &b_m, const Vector3 &c_m, const Colour &colour,
                  float alpha);
    [[nodiscard]] Vector3 across(const Vector3 &at_m, const Vector3 &along_m) const;

    MarkerScale scale_;
    std::vector<FlatVertex> vertices_; ///< three a triangle
};

/// What of these is switched on and there; three vertices a triangle.
[[nodiscard]] std::vector<FlatVertex> flat_marks(const ViewState &state, const MarkerScale &scale);

/// Ellipsoid and sphere of stiffness at the tip, see-through.
[[nodiscard]] std::vector<Solid> stiffness_bodies(const ViewState &state);

/// Their scale: 10 mm for 1 N/mm, less where the longest axis would exceed 60 mm [m per N/m].
[[nodiscard]] double stiffness_scale(const Matrix3 &inverse_N_per_m);

} // namespace springdrive::app
