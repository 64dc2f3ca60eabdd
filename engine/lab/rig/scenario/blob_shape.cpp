#include "engine/lab/rig/scenario/blob_shape.h"

#include "base/bisection.h"

#include <algorithm>

namespace springdrive::rig {

double BlobShape::field(const Vector3 &point) const {
    double sum = 0.0;
    for (const Blob &blob : blobs) {
        const double q = 1.0 - (point - blob.centre).squaredNorm() / (blob.radius * blob.radius);
        sum += q > 0.0 ? q * q * q : 0.0;
    }
    return sum;
}

Vector3 BlobShape::outward_normal(const Vector3 &point) const {
    Vector3 descent = Vector3::Zero();
    for (const Blob &blob : blobs) {
        const double radius_squared = blob.radius * blob.radius;
        const Vector3 offset = point - blob.centre;
        const double q = 1.0 - offset.squaredNorm() / radius_squared;
        if (q > 0.0) {
            descent += (6.0 * q * q / radius_squared) * offset;
        }
    }
    return descent / descent.norm();
}

double BlobShape::distance(const Vector3 &direction) const {
    double outside = 0.0;
    for (const Blob &blob : blobs) {
        outside = std::max(outside, blob.centre.norm() + blob.radius);
    }
    const auto is_inside = [&](double distance) { return field(distance * direction) > level; };
    return bisect({0.0, outside}, 60, is_inside).middle();
}

const BlobShape &organic_shape() {
    static const BlobShape shape{{{Vector3(0.0, 0.0, 0.0), 1.50},
                                  {Vector3(0.85, 0.15, 0.10), 0.80},
                                  {Vector3(-0.80, 0.30, 0.20), 0.85},
                                  {Vector3(0.20, 0.75, -0.25), 0.70},
                                  {Vector3(-0.15, 0.35, 0.75), 0.65},
                                  {Vector3(0.45, -0.35, 0.60), 0.65},
                                  {Vector3(-0.45, -0.45, -0.50), 0.75}},
                                 0.35};
    return shape;
}

} // namespace springdrive::rig
