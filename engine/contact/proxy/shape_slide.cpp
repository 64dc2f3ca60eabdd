#include "engine/contact/proxy/shape_slide.h"

#include "engine/contact/mesh/facet.h"

#include <algorithm>
#include <cmath>
#include <variant>

namespace springdrive::contact {

namespace {

/// Squared cosine of the largest angle by which a face's normal may turn along a slide: beyond 25
/// degrees, the slide leaves the shape more than it follows it.
constexpr double kGentle2 = 0.9 * 0.9;

/// Nearer than this to a centre or an axis [m] the tip's direction from it is ill-defined.
constexpr double kNoDirection_m = 1e-9;

/// A slide in the shape's own frame: along `normal` the tip lies at `depth_m` below the face, and
/// at `lift_m` below the plane that touches the start.
struct LocalSlide {
    Vector3 normal;
    double depth_m;
    double lift_m;
    bool is_flat;
};
using MaybeSlide = std::optional<LocalSlide>;

/// Over the face of a box that is perpendicular to an axis.
[[nodiscard]] MaybeSlide over_side(const Vector3 &half_size_m, int axis, const Vector3 &from_m,
                                   const Vector3 &tip_m, double kept_m) noexcept {
    const int next = (axis + 1) % 3;
    const int last = (axis + 2) % 3;
    const double side = from_m[axis] < 0.0 ? -1.0 : 1.0;
    const bool is_over = std::abs(from_m[next]) <= half_size_m[next] &&
                         std::abs(from_m[last]) <= half_size_m[last] &&
                         std::abs(tip_m[next]) <= half_size_m[next] &&
                         std::abs(tip_m[last]) <= half_size_m[last];
    if (!is_over || side * from_m[axis] - half_size_m[axis] < kept_m) {
        return std::nullopt;
    }
    LocalSlide slide{Vector3::Zero(), half_size_m[axis] - side * tip_m[axis], 0.0, true};
    slide.normal[axis] = side;
    return slide;
}

/// Over a surface at a radius from a centre or, if both points are given relative to it, from an
/// axis.
[[nodiscard]] MaybeSlide over_round(double radius_m, const Vector3 &start_out_m,
                                    const Vector3 &tip_out_m, const Vector3 &way_m,
                                    double kept_m) noexcept {
    const double start_m2 = start_out_m.squaredNorm();
    const double tip_m2 = tip_out_m.squaredNorm();
    const double along_m2 = start_out_m.dot(tip_out_m);
    const double min_m = radius_m + kept_m;
    if (start_m2 < min_m * min_m || tip_m2 < kNoDirection_m * kNoDirection_m || along_m2 < 0.0 ||
        along_m2 * along_m2 < kGentle2 * start_m2 * tip_m2) {
        return std::nullopt;
    }
    const double tip_distance_m = std::sqrt(tip_m2);
    return LocalSlide{tip_out_m / tip_distance_m, radius_m - tip_distance_m,
                      -start_out_m.dot(way_m) * tip_distance_m / along_m2, false};
}

[[nodiscard]] MaybeSlide over(const Plate &plate, const Vector3 &from_m, const Vector3 &tip_m,
                              double kept_m) noexcept {
    return over_side({plate.half_x_m, 0.0, plate.half_z_m}, 1, from_m, tip_m, kept_m);
}

[[nodiscard]] MaybeSlide over(const Sphere &sphere, const Vector3 &from_m, const Vector3 &tip_m,
                              double kept_m) noexcept {
    return over_round(sphere.radius_m, from_m, tip_m, tip_m - from_m, kept_m);
}

[[nodiscard]] MaybeSlide over(const Box &box, const Vector3 &from_m, const Vector3 &tip_m,
                              double kept_m) noexcept {
    int axis = 0;
    (from_m.cwiseAbs() - box.half_size_m).maxCoeff(&axis);
    return over_side(box.half_size_m, axis, from_m, tip_m, kept_m);
}

[[nodiscard]] Vector3 across(const Vector3 &p) noexcept { return {p.x(), 0.0, p.z()}; }

[[nodiscard]] MaybeSlide over(const Cylinder &cylinder, const Vector3 &from_m, const Vector3 &tip_m,
                              double kept_m) noexcept {
    const Vector3 from_across_m = across(from_m);
    const Vector3 tip_across_m = across(tip_m);
    const double half_m = cylinder.half_height_m;
    if (std::abs(from_m.y()) <= half_m && std::abs(tip_m.y()) <= half_m) {
        return over_round(cylinder.radius_m, from_across_m, tip_across_m, tip_m - from_m, kept_m);
    }
    const double radius_m2 = cylinder.radius_m * cylinder.radius_m;
    if (from_across_m.squaredNorm() > radius_m2 || tip_across_m.squaredNorm() > radius_m2) {
        return std::nullopt;
    }
    const Vector3 about_m(cylinder.radius_m, half_m, cylinder.radius_m);
    return over_side(about_m, 1, from_m, tip_m, kept_m);
}

[[nodiscard]] MaybeSlide over(const Capsule &capsule, const Vector3 &from_m, const Vector3 &tip_m,
                              double kept_m) noexcept {
    const auto out_m = [&](const Vector3 &p) {
        const double axis_m = std::clamp(p.y(), -capsule.half_axis_m, capsule.half_axis_m);
        return Vector3(p.x(), p.y() - axis_m, p.z());
    };
    return over_round(capsule.radius_m, out_m(from_m), out_m(tip_m), tip_m - from_m, kept_m);
}

/// Without `std::visit`, which may throw.
[[nodiscard]] MaybeSlide over(const AnalyticShape::Size &size, const Vector3 &from_m,
                              const Vector3 &tip_m, double kept_m) noexcept {
    if (const auto *box = std::get_if<Box>(&size)) {
        return over(*box, from_m, tip_m, kept_m);
    }
    if (const auto *plate = std::get_if<Plate>(&size)) {
        return over(*plate, from_m, tip_m, kept_m);
    }
    if (const auto *cylinder = std::get_if<Cylinder>(&size)) {
        return over(*cylinder, from_m, tip_m, kept_m);
    }
    return over(*std::get_if<Capsule>(&size), from_m, tip_m, kept_m);
}

} // namespace

std::optional<ShapeSlide> slide_over_face(const AnalyticShape &shape, const Vector3 &from_m,
                                          const Vector3 &tip_m, double reach_m) noexcept {
    const double kept_m = reach_m - kLostByRoundOff_m;
    const auto *sphere = std::get_if<Sphere>(&shape.size());
    MaybeSlide slide =
        sphere != nullptr // which has no orientation
            ? over(*sphere, from_m - shape.centre_m(), tip_m - shape.centre_m(), kept_m)
            : over(shape.size(), shape.to_own_frame_m(from_m), shape.to_own_frame_m(tip_m), kept_m);
    if (!slide || slide->depth_m < kSlack_m - reach_m) {
        return std::nullopt;
    }
    const Vector3 normal =
        sphere != nullptr ? slide->normal : Vector3(shape.rotation() * slide->normal);
    const Vector3 rest_m = tip_m + (slide->depth_m + reach_m) * normal;
    const Vector3 over_m = slide->is_flat ? rest_m : Vector3(tip_m + slide->lift_m * normal);
    return ShapeSlide{over_m, rest_m, normal, slide->depth_m, slide->is_flat};
}

} // namespace springdrive::contact
