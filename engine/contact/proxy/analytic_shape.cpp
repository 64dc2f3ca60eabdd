#include "engine/contact/proxy/analytic_shape.h"

#include "base/assertions.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

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

} // namespace springdrive::contact
