// How a proxy slides over one smooth face of a shape, in closed form: to a point straight above its
// place of rest, then down.
#pragma once

#include "base/vector.h"
#include "engine/contact/proxy/analytic_shape.h"

#include <optional>

namespace springdrive::contact {

/// Two motions that never come nearer to the shape than their start and end. On a flat face they
/// are one.
struct ShapeSlide {
    Vector3 over_m; ///< straight above the place of rest, in the plane that touched the start
    Vector3 rest_m; ///< within reach of the face and, of all places over it, nearest to the tip
    Vector3 normal; ///< unit, of the face, from the tip to both of these
    double depth_m; ///< of the tip below the face; negative above it
    bool is_flat = true; ///< the face; `over_m` is `rest_m` then
};

/// Where a proxy with a reach, at rest in `from_m` over one smooth face of a shape, slides when the
/// tip is at `tip_m`: the side of a box or plate, an end or the mantle of a cylinder, the whole of
/// a sphere or capsule. Nothing in other cases: the path leads over an edge or far around the
/// shape, the tip leaves it, or the proxy was nearer than its reach. RT-safe.
[[nodiscard]] std::optional<ShapeSlide> slide_over_face(const AnalyticShape &shape,
                                                        const Vector3 &from_m, const Vector3 &tip_m,
                                                        double reach_m) noexcept;

} // namespace springdrive::contact
