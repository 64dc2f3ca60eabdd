// Shapes placed in the world, the elements of linkage and markers; without OpenGL.
#pragma once

#include "app/view/shapes.h"
#include "base/vector.h"

#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <vector>

namespace springdrive::app {

/// A colour in sRGB, 0 to 1, as in ImGui.
using Colour = std::array<float, 3>;

struct Solid {
    Shape shape = Shape::ball;
    glm::mat4 model{1.0F};
    glm::vec4 colour{1.0F}; ///< linear
};

/// The colour in linear light, opaque.
[[nodiscard]] glm::vec4 linear(const Colour &colour);

[[nodiscard]] Solid ball(const Vector3 &centre_m, double radius_m, const Colour &colour);

/// A cylinder, taper or cone from one point to another. @pre the points differ
[[nodiscard]] Solid spindle(Shape shape, const Vector3 &from_m, const Vector3 &to_m,
                            double radius_m, const Colour &colour);

/// @param axis unit, normal to the ring's plane
[[nodiscard]] Solid ring(const Vector3 &centre_m, const Vector3 &axis, double radius_m,
                         const Colour &colour);

} // namespace springdrive::app
