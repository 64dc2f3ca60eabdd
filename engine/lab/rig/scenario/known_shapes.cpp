#include "engine/lab/rig/scenario/known_shapes.h"

#include "base/bisection.h"
#include "engine/lab/rig/scenario/test_surfaces.h"

#include <algorithm>
#include <cmath>
#include <numbers>

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

namespace {

constexpr double kMinDepth_m = 1e-3;
constexpr double kMaxDepth_m = 2e-3;

/// Of longitude for each tip [rad]: about 0.1 m/s in the mean on the test sphere at 1 kHz.
constexpr double kPhaseStep = 2e-3;

Vector3 direction_of(std::size_t tip) {
    return lissajous_direction(kPhaseStep * static_cast<double>(tip));
}

PressedTip pressed(const Vector3 &surface_m, const Vector3 &normal, double depth_m) {
    return {surface_m - depth_m * normal, surface_m, normal};
}

} // namespace

Vector3 lissajous_direction(double phase) {
    const double latitude = 1.2 * std::sin(phase / std::numbers::phi);
    return {std::cos(latitude) * std::cos(phase), std::sin(latitude),
            std::cos(latitude) * std::sin(phase)};
}

double swing_m(std::size_t tip, double min_m, double max_m) {
    const double share = 0.5 + 0.5 * std::sin(2.7e-3 * static_cast<double>(tip));
    return min_m + share * (max_m - min_m);
}

std::vector<PressedTip> tips_in_sphere(std::size_t count) {
    std::vector<PressedTip> tips;
    for (std::size_t i = 0; i < count; ++i) {
        const Vector3 direction = direction_of(i).normalized();
        tips.push_back(pressed(kTestSphereRadius_m * direction, direction,
                               swing_m(i, kMinDepth_m, kMaxDepth_m)));
    }
    return tips;
}

std::vector<PressedTip> tips_in_organic_shape(std::size_t count) {
    const BlobShape &shape = organic_shape();
    std::vector<PressedTip> tips;
    for (std::size_t i = 0; i < count; ++i) {
        const Vector3 direction = direction_of(i).normalized();
        const Vector3 point = shape.distance(direction) * direction;
        tips.push_back(pressed(kTestOrganicScale_m * point, shape.outward_normal(point),
                               swing_m(i, kMinDepth_m, kMaxDepth_m)));
    }
    return tips;
}

Vector3 thin_plate_half_size_m() { return {0.05, 1e-3, 0.05}; }

std::vector<PressedTip> tips_in_thin_plate(std::size_t count) {
    const Vector3 half_m = thin_plate_half_size_m();
    const double thickness_m = 2.0 * half_m.y();
    std::vector<PressedTip> tips;
    for (std::size_t i = 0; i < count; ++i) {
        const Vector3 direction = direction_of(i);
        const Vector3 top_m(0.6 * half_m.x() * direction.x(), half_m.y(),
                            0.6 * half_m.z() * direction.z());
        tips.push_back(
            pressed(top_m, Vector3::UnitY(), swing_m(i, 0.25 * thickness_m, 0.75 * thickness_m)));
    }
    return tips;
}

} // namespace springdrive::rig
