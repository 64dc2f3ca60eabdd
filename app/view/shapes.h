// The unit shapes of linkage and markers, as triangles; without OpenGL.
#pragma once

#include "engine/scene/scene.h"

#include <array>
#include <cstdint>
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

} // namespace springdrive::app
