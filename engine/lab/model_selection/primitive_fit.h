// Whether a mesh is a plate, sphere, box, cylinder or capsule, and how far it is from being one.
#pragma once

#include "engine/contact/mesh/triangle_soup.h"
#include "engine/contact/proxy/analytic_shape.h"

#include <cstdint>
#include <optional>

namespace springdrive::model_selection {

/// A shape that a mesh may stand for.
struct PrimitiveFit {
    contact::AnalyticShape shape;
    double deviation_m = 0.0; ///< greatest distance of the mesh's corners and middles from it
};

/// The shape nearest to the triangles of one material, if one comes within 2 % of their extent and
/// holds as much volume (a plate: has as large an area) as they, to 5 %. So an open bowl is no
/// sphere, and a room no box. The frames tried are those of the device, of the largest faces and of
/// the principal axes.
[[nodiscard]] std::optional<PrimitiveFit> fit_primitive(const contact::TriangleSoup &soup,
                                                        std::uint16_t material);

} // namespace springdrive::model_selection
