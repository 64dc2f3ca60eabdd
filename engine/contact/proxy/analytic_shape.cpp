#include "engine/contact/proxy/analytic_shape.h"

#include "base/assertions.h"
#include "engine/contact/mesh/facet.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <variant>

namespace springdrive::contact {

namespace {

/// Squares below this begin to lose digits.
constexpr double kMinSquare_m2 = 1e-280;

/// In the direction of `v`, however short. @pre v is not zero
[[nodiscard]] Vector3 unit(const Vector3 &v) noexcept {
    const double length2 = v.squaredNorm();
    if (length2 > kMinSquare_m2) {
        return v / std::sqrt(length2);
    }
    const double largest = v.cwiseAbs().maxCoeff();
    SPRINGDRIVE_ASSERT(largest != 0.0);
    const Vector3 scaled = v / largest;
    return scaled / scaled.norm();
}

[[nodiscard]] double side(double coordinate) noexcept { return coordinate < 0.0 ? -1.0 : 1.0; }

/// Unit, away from the y axis; along x on the axis itself.
[[nodiscard]] Vector3 radial_direction(const Vector3 &p) noexcept {
    const Vector3 away(p.x(), 0.0, p.z());
    return away.isZero(0.0) ? Vector3::UnitX() : unit(away);
}

/// For a point `p` off a convex shape whose nearest point is `on_m`.
[[nodiscard]] NearestOnShape outside(const Vector3 &p, const Vector3 &on_m) noexcept {
    const Vector3 normal = unit(p - on_m);
    return {on_m, normal, normal.dot(p - on_m)};
}

[[nodiscard]] NearestOnShape nearest_on(const Plate &plate, const Vector3 &p) noexcept {
    const Vector3 on_m(std::clamp(p.x(), -plate.half_x_m, plate.half_x_m), 0.0,
                       std::clamp(p.z(), -plate.half_z_m, plate.half_z_m));
    return p == on_m ? NearestOnShape{on_m, Vector3::UnitY(), 0.0} : outside(p, on_m);
}

[[nodiscard]] NearestOnShape nearest_on(const Sphere &sphere, const Vector3 &p) noexcept {
    const Vector3 normal = p.isZero(0.0) ? Vector3(Vector3::UnitY()) : unit(p);
    return {sphere.radius_m * normal, normal, p.norm() - sphere.radius_m};
}

[[nodiscard]] NearestOnShape nearest_on(const Box &box, const Vector3 &p) noexcept {
    const Vector3 on_m = p.cwiseMax(-box.half_size_m).cwiseMin(box.half_size_m);
    if (p != on_m) {
        return outside(p, on_m);
    }
    int face = 0;
    const double distance_m = (p.cwiseAbs() - box.half_size_m).maxCoeff(&face);
    NearestOnShape nearest{on_m, Vector3::Zero(), distance_m};
    nearest.normal[face] = side(p[face]);
    nearest.point_m[face] = side(p[face]) * box.half_size_m[face];
    return nearest;
}

[[nodiscard]] NearestOnShape nearest_on(const Cylinder &cylinder, const Vector3 &p) noexcept {
    const Vector3 radial = radial_direction(p);
    const double above_mantle_m = std::hypot(p.x(), p.z()) - cylinder.radius_m;
    const double above_end_m = std::abs(p.y()) - cylinder.half_height_m;
    const Vector3 axial(0.0, side(p.y()), 0.0);
    const Vector3 on_mantle_m = cylinder.radius_m * radial;
    const Vector3 on_end_m = cylinder.half_height_m * axial;
    const Vector3 across_m(p.x(), 0.0, p.z());
    if (above_mantle_m > 0.0 && above_end_m > 0.0) { // the rim
        const Vector3 away_m = above_mantle_m * radial + above_end_m * axial;
        return {on_mantle_m + on_end_m, unit(away_m), std::hypot(above_mantle_m, above_end_m)};
    }
    if (above_mantle_m > above_end_m) {
        return {on_mantle_m + Vector3(0.0, p.y(), 0.0), radial, above_mantle_m};
    }
    return {across_m + on_end_m, axial, above_end_m};
}

[[nodiscard]] NearestOnShape nearest_on(const Capsule &capsule, const Vector3 &p) noexcept {
    const Vector3 axis_m(0.0, std::clamp(p.y(), -capsule.half_axis_m, capsule.half_axis_m), 0.0);
    const Vector3 normal = p == axis_m ? Vector3(Vector3::UnitX()) : unit(p - axis_m);
    return {axis_m + capsule.radius_m * normal, normal, (p - axis_m).norm() - capsule.radius_m};
}

/// Without `std::visit`, which may throw.
[[nodiscard]] NearestOnShape nearest_on(const AnalyticShape::Size &size,
                                        const Vector3 &p) noexcept {
    if (const auto *plate = std::get_if<Plate>(&size)) {
        return nearest_on(*plate, p);
    }
    if (const auto *sphere = std::get_if<Sphere>(&size)) {
        return nearest_on(*sphere, p);
    }
    if (const auto *box = std::get_if<Box>(&size)) {
        return nearest_on(*box, p);
    }
    if (const auto *cylinder = std::get_if<Cylinder>(&size)) {
        return nearest_on(*cylinder, p);
    }
    return nearest_on(*std::get_if<Capsule>(&size), p);
}

/// For points relative to a centre: whether both lie in front of the plane perpendicular to
/// `from_m` at distance `min_m`. Without a root or a division, as it is called in every tick.
[[nodiscard]] bool are_beyond(double min_m, const Vector3 &from_m, const Vector3 &to_m) noexcept {
    const double from_m2 = from_m.squaredNorm();
    const double along_m2 = from_m.dot(to_m);
    const double min_m2 = min_m * min_m;
    return from_m2 >= min_m2 && along_m2 >= 0.0 && along_m2 * along_m2 >= min_m2 * from_m2;
}

[[nodiscard]] bool is_parted(const Box &box, const Vector3 &from_m, const Vector3 &to_m,
                             double clear_m) noexcept {
    const Vector3 on_m = from_m.cwiseMax(-box.half_size_m).cwiseMin(box.half_size_m);
    return are_beyond(clear_m, from_m - on_m, to_m - on_m);
}

[[nodiscard]] bool is_parted(const Sphere &sphere, const Vector3 &from_m, const Vector3 &to_m,
                             double clear_m) noexcept {
    return are_beyond(sphere.radius_m + clear_m, from_m, to_m);
}

[[nodiscard]] bool is_parted(const Cylinder &cylinder, const Vector3 &from_m, const Vector3 &to_m,
                             double clear_m) noexcept {
    const Vector3 across(1.0, 0.0, 1.0);
    const double min_m = cylinder.half_height_m + clear_m;
    return std::min(from_m.y(), to_m.y()) >= min_m || std::max(from_m.y(), to_m.y()) <= -min_m ||
           are_beyond(cylinder.radius_m + clear_m, from_m.cwiseProduct(across),
                      to_m.cwiseProduct(across));
}

[[nodiscard]] bool is_parted(const Capsule &capsule, const Vector3 &from_m, const Vector3 &to_m,
                             double clear_m) noexcept {
    const Vector3 axis_m(0.0, std::clamp(from_m.y(), -capsule.half_axis_m, capsule.half_axis_m),
                         0.0);
    return are_beyond(capsule.radius_m + clear_m, from_m - axis_m, to_m - axis_m);
}

[[nodiscard]] bool is_parted(const AnalyticShape::Size &size, const Vector3 &from_m,
                             const Vector3 &to_m, double clear_m) noexcept {
    if (const auto *box = std::get_if<Box>(&size)) {
        return is_parted(*box, from_m, to_m, clear_m);
    }
    if (const auto *plate = std::get_if<Plate>(&size)) {
        return is_parted(Box{{plate->half_x_m, 0.0, plate->half_z_m}}, from_m, to_m, clear_m);
    }
    if (const auto *cylinder = std::get_if<Cylinder>(&size)) {
        return is_parted(*cylinder, from_m, to_m, clear_m);
    }
    if (const auto *capsule = std::get_if<Capsule>(&size)) {
        return is_parted(*capsule, from_m, to_m, clear_m);
    }
    return is_parted(*std::get_if<Sphere>(&size), from_m, to_m, clear_m);
}

/// Half the extents of a shape that `R` has turned.
[[nodiscard]] Vector3 half_extent_m(const Plate &plate, const Matrix3 &R) {
    return R.cwiseAbs() * Vector3(plate.half_x_m, 0.0, plate.half_z_m);
}

[[nodiscard]] Vector3 half_extent_m(const Sphere &sphere, const Matrix3 & /*R*/) {
    return Vector3::Constant(sphere.radius_m);
}

[[nodiscard]] Vector3 half_extent_m(const Box &box, const Matrix3 &R) {
    return R.cwiseAbs() * box.half_size_m;
}

[[nodiscard]] Vector3 half_extent_m(const Cylinder &cylinder, const Matrix3 &R) {
    const Vector3 of_ends = (R.col(0).cwiseAbs2() + R.col(2).cwiseAbs2()).cwiseSqrt();
    return cylinder.half_height_m * R.col(1).cwiseAbs() + cylinder.radius_m * of_ends;
}

[[nodiscard]] Vector3 half_extent_m(const Capsule &capsule, const Matrix3 &R) {
    return capsule.half_axis_m * R.col(1).cwiseAbs() + Vector3::Constant(capsule.radius_m);
}

/// The lengths of a shape, all of which must be positive.
[[nodiscard]] Vector3 lengths_m(const AnalyticShape::Size &size) {
    struct Lengths {
        Vector3 operator()(const Plate &s) const { return {s.half_x_m, s.half_z_m, 1.0}; }
        Vector3 operator()(const Sphere &s) const { return {s.radius_m, 1.0, 1.0}; }
        Vector3 operator()(const Box &s) const { return s.half_size_m; }
        Vector3 operator()(const Cylinder &s) const { return {s.radius_m, s.half_height_m, 1.0}; }
        Vector3 operator()(const Capsule &s) const {
            return {s.radius_m, s.half_axis_m == 0.0 ? 1.0 : s.half_axis_m, 1.0};
        }
    };
    return std::visit(Lengths{}, size);
}

} // namespace

AnalyticShape::AnalyticShape(const Size &size, const Eigen::Isometry3d &placement,
                             std::uint16_t material)
    : size_(size), rotation_(placement.linear()), centre_m_(placement.translation()),
      material_(material) {
    const Vector3 lengths = lengths_m(size);
    if (!lengths.allFinite() || !(lengths.minCoeff() > 0.0)) {
        throw std::invalid_argument("the size of an analytic shape must be positive and finite");
    }
}

NearestOnShape AnalyticShape::nearest(const Vector3 &point_m) const noexcept {
    // Otherwise the result is not finite either, and the servo's safety monitor trips on it.
    SPRINGDRIVE_ASSERT_AUDIT(point_m.allFinite());
    const NearestOnShape local = nearest_on(size_, to_own_frame_m(point_m));
    return {centre_m_ + rotation_ * local.point_m, rotation_ * local.normal, local.distance_m};
}

bool AnalyticShape::is_parted_from(const Vector3 &from_m, const Vector3 &to_m,
                                   double clear_m) const noexcept {
    if (const auto *sphere = std::get_if<Sphere>(&size_)) { // which no rotation changes
        return is_parted(*sphere, from_m - centre_m_, to_m - centre_m_, clear_m);
    }
    return is_parted(size_, to_own_frame_m(from_m), to_own_frame_m(to_m), clear_m);
}

Eigen::AlignedBox3d AnalyticShape::bounds() const {
    const Vector3 half_m =
        std::visit([&](const auto &shape) { return half_extent_m(shape, rotation_); }, size_);
    return {Vector3(centre_m_ - half_m), Vector3(centre_m_ + half_m)};
}

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
