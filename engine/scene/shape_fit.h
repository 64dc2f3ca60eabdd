// The exact shape that a mesh stands for: one that its file names, or one recognised from its
// triangles.
#pragma once

#include "engine/contact/mesh/triangle_soup.h"
#include "engine/contact/proxy/analytic_shape.h"
#include "engine/scene/scene.h"

#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace springdrive::scene {

/// The exact shapes that a node's mesh may stand for.
enum class ShapeKind : std::uint8_t { plate, sphere, box, cylinder, capsule };

/// As files spell them, in the order of ShapeKind.
inline constexpr std::array<std::string_view, 5> kShapeNames = {"plate", "sphere", "box",
                                                                "cylinder", "capsule"};

[[nodiscard]] std::string name_of(ShapeKind shape);

/// Fits a shape that the file names to the box around its mesh.
///
/// - plate: one extent of the box is below 1 % of the largest; the plate lies across it, in the
///   middle.
/// - sphere: the three extents agree within 1 %. The largest counts, as not every tessellation
///   reaches all its poles.
/// - cylinder, capsule: along the mesh's y axis; the extents in x and z agree within 1 %, and the
///   larger counts. A capsule is at least as high as wide.
///
/// @param box around the mesh, in its own coordinates
/// @param to_device from these to the device's frame: may turn, mirror and scale uniformly; for
///        a plate or a box also along each axis, as long as right angles stay right
/// @param label of the node, for messages
/// @throw InputError, one line, for a box or a transform that gives no such shape.
[[nodiscard]] contact::AnalyticShape fit_shape(ShapeKind kind, const BoundingBox &box,
                                               const Eigen::Affine3d &to_device,
                                               std::uint16_t material, const std::string &label);

/// A shape that triangles may be replaced by.
struct RecognisedShape {
    contact::AnalyticShape shape;
    double deviation_m = 0.0; ///< greatest distance of the mesh's corners and middles from it
};

/// The shape nearest to the triangles of one material, in the device's frame, if one comes within
/// 2 % of their extent and has the same volume (a plate: the same area) to 5 %. So an open bowl is
/// no sphere, and a room no box. The frames tried are those of the device, of the largest faces and
/// of the principal axes.
[[nodiscard]] std::optional<RecognisedShape> recognise_shape(const contact::TriangleSoup &soup,
                                                             std::uint16_t material);

} // namespace springdrive::scene
