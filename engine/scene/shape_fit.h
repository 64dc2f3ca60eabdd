// From the mesh of a node to the exact shape that it stands for.
#pragma once

#include "engine/contact/proxy/analytic_shape.h"
#include "engine/scene/fit.h"
#include "engine/scene/gltf_nodes.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <string>

namespace springdrive::scene::gltf {

/// Fits a shape to the box around a mesh.
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

} // namespace springdrive::scene::gltf
