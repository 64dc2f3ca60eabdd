// The flat marks of a touch, as triangles: forces of both maps, contact plane, set-point,
// stiffness, trace, workspace. Many of them are drawn at once, which one solid each would not
// allow; without OpenGL.
#pragma once

#include "app/view/camera.h"
#include "app/view/solids.h"
#include "app/view/view_state.h"

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <utility>
#include <vector>

namespace springdrive::app {

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
