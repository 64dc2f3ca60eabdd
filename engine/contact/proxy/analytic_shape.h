// Shapes that are touched exactly, where triangles would only approximate them.
#pragma once

#include "base/vector.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <optional>
#include <variant>

namespace springdrive::contact {

// The shapes in their own frame: centred on the origin, sizes in metres.

/// A rectangle in the plane y = 0, of no thickness, touched from both sides.
struct Plate {
    double half_x_m;
    double half_z_m;
};

struct Sphere {
    double radius_m;
};

struct Box {
    Vector3 half_size_m;
};

/// Along y, with flat ends.
struct Cylinder {
    double radius_m;
    double half_height_m;
};

/// All that lies within a radius of a piece of the y axis.
struct Capsule {
    double radius_m;
    double half_axis_m; ///< from the centre to that of a cap; without the cap itself
};

struct NearestOnShape {
    Vector3 point_m;   ///< nearest point of the surface
    Vector3 normal;    ///< unit, there, towards the side of the query
    double distance_m; ///< from the surface; negative inside a solid
};

/// A convex shape with its placement.
///
/// The plane through a nearest point, perpendicular to its normal, has the whole shape behind it.
/// For a query off the shape, the query is in front; for one inside a solid, it is behind as well.
class AnalyticShape {
public:
    using Size = std::variant<Plate, Sphere, Box, Cylinder, Capsule>;

    /// @param placement maps the shape's own frame to the device's
    /// @param material index into the scene's materials
    /// @throw std::invalid_argument for a size that is not positive and finite: a mistake of the
    ///        program. Only the half axis of a capsule may be 0.
    AnalyticShape(const Size &size, const Eigen::Isometry3d &placement, std::uint16_t material);

    /// The nearest point of the surface. Where several are equally near, as from the centre of a
    /// sphere, it is always the same one. RT-safe. @pre `point_m` is finite
    [[nodiscard]] NearestOnShape nearest(const Vector3 &point_m) const noexcept;

    /// Whether a plane separates the shape, grown by `clear_m`, from a motion. A quick,
    /// conservative test: true is certain but for round-off. RT-safe.
    [[nodiscard]] bool is_parted_from(const Vector3 &from_m, const Vector3 &to_m,
                                      double clear_m) const noexcept;

    /// The bounding box of the shape along the device's axes.
    [[nodiscard]] Eigen::AlignedBox3d bounds() const;

    [[nodiscard]] std::uint16_t material() const noexcept { return material_; }

    /// Whether it has an inside, which a tip may leave but not enter. All have except the plate.
    [[nodiscard]] bool is_solid() const noexcept { return !std::holds_alternative<Plate>(size_); }

    [[nodiscard]] const Size &size() const noexcept { return size_; }

    /// A point of the device's frame in the shape's own frame. RT-safe.
    [[nodiscard]] Vector3 to_own_frame_m(const Vector3 &point_m) const noexcept {
        return rotation_.transpose() * (point_m - centre_m_);
    }

    [[nodiscard]] const Vector3 &centre_m() const noexcept { return centre_m_; }

    /// Rotates directions of the shape's own frame to the device's.
    [[nodiscard]] const Matrix3 &rotation() const noexcept { return rotation_; }

private:
    Size size_;
    Matrix3 rotation_; ///< shape to device
    Vector3 centre_m_;
    std::uint16_t material_;
};

// How a proxy slides over one smooth face of a shape, in closed form: to a point straight above its
// place of rest, then down.

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
