// The elements of linkage and markers: unit shapes as triangles, placed in the world; the PHANTOM
// as solid bars and joints, built from its kinematics; without OpenGL. And the only conversions
// between the program's vectors (Eigen, double, metres) and the renderer's (GLM, float).
#pragma once

#include "base/vector.h"
#include "device/core/phantom/kinematics.h"
#include "engine/scene/scene.h"

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace springdrive::app {

[[nodiscard]] inline glm::vec3 to_glm(const Vector3 &v) {
    return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

[[nodiscard]] inline Vector3 to_vector3(const glm::vec3 &v) { return {v.x, v.y, v.z}; }

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

/// What moves as one. The base turns about the vertical, too, but looks the same then but for its
/// motors.
enum class LinkagePart : std::uint8_t { base, upper_arm, crank, rod, forearm };

struct LinkageSolid {
    LinkagePart part = LinkagePart::base;
    Solid solid;
};

/// Plate, hub, column and motors of the base, upper arm, crank, rod, and the forearm, tapered
/// towards the tip. Parts that share a joint meet about its axis; otherwise none passes through
/// another. Red when tripped.
[[nodiscard]] std::vector<LinkageSolid> linkage_parts(const device::LinkagePose &pose,
                                                      double floor_height_m, bool tripped);

/// The same without their parts.
[[nodiscard]] std::vector<Solid> linkage_solids(const device::LinkagePose &pose,
                                                double floor_height_m, bool tripped);

} // namespace springdrive::app
