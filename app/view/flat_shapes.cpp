#include "app/view/flat_shapes.h"

#include "app/view/gl_vector.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace springdrive::app {

namespace {

constexpr int kCorners = 64; // of an ellipse

Vector3 on_ellipse(const Vector3 &centre_m, const Vector3 &a_m, const Vector3 &b_m, int corner) {
    const double angle_rad = 2.0 * std::numbers::pi * corner / kCorners;
    return centre_m + std::cos(angle_rad) * a_m + std::sin(angle_rad) * b_m;
}

glm::vec4 with_alpha(const Colour &colour, float alpha) {
    return {colour[0], colour[1], colour[2], alpha};
}

} // namespace

/// Unit, square to the line and to the line of sight; any where one looks along the line.
Vector3 FlatShapes::across(const Vector3 &at_m, const Vector3 &along_m) const {
    const Vector3 sight_m = at_m - scale_.camera.eye_m();
    const Vector3 across_m = along_m.cross(sight_m);
    constexpr double kAlong = 1e-6; // sine
    return across_m.norm() > kAlong * along_m.norm() * sight_m.norm() ? across_m.normalized()
                                                                      : scale_.camera.right();
}

void FlatShapes::triangle(const Vector3 &a_m, const Vector3 &b_m, const Vector3 &c_m,
                          const Colour &colour, float alpha) {
    for (const Vector3 *corner_m : {&a_m, &b_m, &c_m}) {
        vertices_.push_back({to_glm(*corner_m), with_alpha(colour, alpha)});
    }
}

void FlatShapes::line(const Vector3 &from_m, const Vector3 &to_m, double width_px,
                      const Colour &from, const Colour &to, float alpha) {
    if (from_m == to_m) {
        return;
    }
    const Vector3 side = across(0.5 * (from_m + to_m), to_m - from_m);
    const Vector3 half_from_m = 0.5 * scale_.length_m(width_px, from_m) * side;
    const Vector3 half_to_m = 0.5 * scale_.length_m(width_px, to_m) * side;
    const FlatVertex left_from{to_glm(from_m - half_from_m), with_alpha(from, alpha)};
    const FlatVertex right_from{to_glm(from_m + half_from_m), with_alpha(from, alpha)};
    const FlatVertex left_to{to_glm(to_m - half_to_m), with_alpha(to, alpha)};
    const FlatVertex right_to{to_glm(to_m + half_to_m), with_alpha(to, alpha)};
    vertices_.insert(vertices_.end(),
                     {left_from, right_from, right_to, left_from, right_to, left_to});
}

void FlatShapes::ellipse(const Vector3 &centre_m, const Vector3 &a_m, const Vector3 &b_m,
                         double width_px, const Colour &colour, float alpha) {
    for (int corner = 0; corner < kCorners; ++corner) {
        line(on_ellipse(centre_m, a_m, b_m, corner), on_ellipse(centre_m, a_m, b_m, corner + 1),
             width_px, colour, alpha);
    }
}

void FlatShapes::disc(const Vector3 &centre_m, const Vector3 &a_m, const Vector3 &b_m,
                      const Colour &colour, float alpha) {
    for (int corner = 0; corner < kCorners; ++corner) {
        triangle(centre_m, on_ellipse(centre_m, a_m, b_m, corner),
                 on_ellipse(centre_m, a_m, b_m, corner + 1), colour, alpha);
    }
}

void FlatShapes::arrow(const Vector3 &from_m, const Vector3 &along_m, double width_px,
                       const Colour &colour, float alpha) {
    constexpr double kHeadPerWidth = 2.4; // its width; its length is 0.9 of that
    const Vector3 end_m = from_m + along_m;
    const double head_m = scale_.length_m(kHeadPerWidth * width_px, end_m);
    const double length_m = along_m.norm();
    const Vector3 neck_m = end_m - std::min(0.9 * head_m / length_m, 0.6) * along_m;
    const Vector3 half_m = 0.5 * head_m * across(neck_m, along_m);
    line(from_m, neck_m, width_px, colour, alpha);
    triangle(neck_m - half_m, neck_m + half_m, end_m, colour, alpha);
}

void FlatShapes::dot(const Vector3 &centre_m, double radius_m, const Colour &colour, float alpha) {
    const Vector3 right_m = radius_m * scale_.camera.right();
    const Vector3 up_m = radius_m * scale_.camera.up();
    triangle(centre_m - right_m, centre_m - up_m, centre_m + right_m, colour, alpha);
    triangle(centre_m - right_m, centre_m + right_m, centre_m + up_m, colour, alpha);
}

} // namespace springdrive::app
