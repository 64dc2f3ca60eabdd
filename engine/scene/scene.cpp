#include "engine/scene/scene.h"

#include "base/input_error.h"
#include "base/text.h"

#include <cmath>
#include <limits>
#include <new>
#include <string>

namespace springdrive::scene {

BoundingBox::BoundingBox()
    : lower(Vector3::Constant(std::numeric_limits<double>::infinity())),
      upper(Vector3::Constant(-std::numeric_limits<double>::infinity())) {}

void BoundingBox::include(const Vector3 &point) {
    lower = lower.cwiseMin(point);
    upper = upper.cwiseMax(point);
}

Fit fit_into(const device::Workspace &workspace, const BoundingBox &box) {
    const Vector3 extent = box.extent();
    if (!extent.allFinite()) {
        throw InputError("its coordinates are too large to compute with; scale it down");
    }
    double scale = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        if (extent[axis] > 0.0) { // a flat scene fits along its normal whatever the scale
            scale = std::min(scale, kFilledShare * workspace.size_m[axis] / extent[axis]);
        }
    }
    if (!std::isfinite(scale)) {
        throw InputError("all its triangles lie in one point; there is nothing to touch");
    }
    return {box.lower + 0.5 * extent, workspace.centre_m, scale};
}

bool lies_within(const device::Workspace &workspace, const BoundingBox &box) {
    const Vector3 half_size = 0.5 * workspace.size_m;
    // The rounding of a file's single-precision coordinates is no reason for a warning.
    constexpr double kRounding_m = 1e-6;
    return ((box.lower - workspace.centre_m + half_size).array() >= -kRounding_m).all() &&
           ((box.upper - workspace.centre_m - half_size).array() <= kRounding_m).all();
}

contact::HapticSurface haptic_surface_of(const Scene &scene) {
    const std::string place = one_line(scene.file.string(), 1000) + ": ";
    const auto prepared = [&] {
        try {
            return contact::HapticSurface(scene.surface, scene.shapes);
        } catch (const InputError &error) {
            throw InputError(place + error.what());
        } catch (const std::bad_alloc &) {
            throw InputError(place + "needs more memory than there is; simplify it");
        }
    };
    contact::HapticSurface surface = prepared();
    if (surface.report().triangles_kept == 0 && surface.shapes().empty()) {
        throw InputError(place + "has nothing to touch: its triangles, " +
                         std::to_string(surface.report().triangles_given) +
                         " in number, are all too thin to have a normal; export it again");
    }
    return surface;
}

} // namespace springdrive::scene
