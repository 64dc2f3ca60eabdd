#include "app/view/solids.h"

#include "app/view/gl_vector.h"
#include "base/assertions.h"

#include <Eigen/Geometry>

#include <cmath>

namespace springdrive::app {

namespace {

/// Maps z to `axis` and the unit circle in x, y to one of `radius_m` about it.
glm::mat4 placed_along(const Vector3 &origin_m, const Vector3 &axis_m, double radius_m) {
    const Vector3 across = axis_m.unitOrthogonal();
    const Vector3 third = axis_m.normalized().cross(across);
    return {glm::vec4(to_glm(radius_m * across), 0.0F), glm::vec4(to_glm(radius_m * third), 0.0F),
            glm::vec4(to_glm(axis_m), 0.0F), glm::vec4(to_glm(origin_m), 1.0F)};
}

float linear(float srgb) {
    return srgb <= 0.04045F ? srgb / 12.92F : std::pow((srgb + 0.055F) / 1.055F, 2.4F);
}

} // namespace

glm::vec4 linear(const Colour &colour) {
    return {linear(colour[0]), linear(colour[1]), linear(colour[2]), 1.0F};
}

Solid ball(const Vector3 &centre_m, double radius_m, const Colour &colour) {
    return {Shape::ball, placed_along(centre_m, radius_m * Vector3::UnitZ(), radius_m),
            linear(colour)};
}

Solid spindle(Shape shape, const Vector3 &from_m, const Vector3 &to_m, double radius_m,
              const Colour &colour) {
    SPRINGDRIVE_ASSERT(from_m != to_m);
    return {shape, placed_along(from_m, to_m - from_m, radius_m), linear(colour)};
}

Solid ring(const Vector3 &centre_m, const Vector3 &axis, double radius_m, const Colour &colour) {
    return {Shape::ring, placed_along(centre_m, radius_m * axis, radius_m), linear(colour)};
}

} // namespace springdrive::app
