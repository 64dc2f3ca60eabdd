// The elements of linkage and markers: unit shapes as triangles, placed in the world; without
// OpenGL.
#pragma once

#include "base/vector.h"
#include "engine/scene/scene.h"

#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace springdrive::app {

/// All lie on the z axis and are wound counter-clockwise seen from outside.
enum class Shape : std::uint8_t {
    ball,     ///< radius 1 about the origin
    cylinder, ///< radius 1, z from 0 to 1, closed
    taper,    ///< like the cylinder, but with radius kTaperEnd at z = 1
    cone,     ///< radius 1 at z = 0, its apex at z = 1, closed
    ring,     ///< of mean radius 1 in the plane z = 0, kRingThickness thick
};

inline constexpr std::array kShapes{Shape::ball, Shape::cylinder, Shape::taper, Shape::cone,
                                    Shape::ring};
inline constexpr float kTaperEnd = 0.4F;
inline constexpr float kRingThickness = 0.2F;

struct ShapeMesh {
    std::vector<scene::VisualVertex> vertices; ///< white
    std::vector<std::uint32_t> indices;        ///< three per triangle
};

[[nodiscard]] ShapeMesh make_shape(Shape shape);

/// The same, made once.
[[nodiscard]] const ShapeMesh &unit_shape(Shape shape);

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

/// Points whose convex hull contains all of the solids, as they are drawn.
[[nodiscard]] std::vector<Vector3> drawn_points(std::span<const Solid> solids);

} // namespace springdrive::app
