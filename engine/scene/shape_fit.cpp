#include "engine/scene/shape_fit.h"

#include "base/eigenvalues.h"
#include "base/input_error.h"
#include "base/text.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace springdrive::scene {

namespace {

/// Of the largest extent: what is thinner is a plate.
constexpr double kFlatness = 0.01;

// How far a mesh may deviate from its shape. A shape that the file names is used as it is, so no
// more is accepted than tessellation explains; beyond that, loading fails. A recognised one is a
// candidate only: model selection measures what it does to the force before using it, so its limits
// need only exclude other shapes, such as an open bowl.
constexpr double kNamedLikeness = 0.01;      // of the extents
constexpr double kRecognisedLikeness = 0.02; // of the largest extent, at every point
constexpr double kFullness = 0.05;           // of volume or area

constexpr double kSameDirection = 0.1; // sine of the angle up to which two faces are parallel

/// What a matrix of single-precision numbers, or a unit quaternion of few digits, may be off.
constexpr double kTransformRounding = 1e-4;

/// A box in the device's frame.
struct PlacedBox {
    Eigen::Isometry3d placement; ///< of its centre and its axes
    Vector3 half_m;
};

/// The same box with its axis `y` as the second one, still right-handed.
PlacedBox with_second_axis(const PlacedBox &box, int y) {
    const int x = (y + 2) % 3;
    const int z = (y + 1) % 3;
    const Matrix3 axes = box.placement.linear();
    PlacedBox turned = box;
    turned.placement.linear() << axes.col(x), axes.col(y), axes.col(z);
    turned.half_m = {box.half_m[x], box.half_m[y], box.half_m[z]};
    return turned;
}

bool is_flat(const Vector3 &half, int axis) { return half[axis] < kFlatness * half.maxCoeff(); }

// The shapes that fill a box; plates lie across its second axis, round ones stand along it.

contact::Plate plate_across(const Vector3 &half_m) { return {half_m.x(), half_m.z()}; }

double radius_within(const Vector3 &half_m) { return std::max(half_m.x(), half_m.z()); }

contact::Cylinder cylinder_along(const Vector3 &half_m) {
    return {radius_within(half_m), half_m.y()};
}

contact::Capsule capsule_along(const Vector3 &half_m) {
    const double radius_m = radius_within(half_m);
    return {radius_m, std::max(half_m.y() - radius_m, 0.0)};
}

Matrix3 right_handed(Matrix3 axes) {
    if (axes.determinant() < 0.0) {
        axes.col(2) = -axes.col(2);
    }
    return axes;
}

std::string shown(const Vector3 &extent) {
    return shortest_text(extent.x()) + " by " + shortest_text(extent.y()) + " by " +
           shortest_text(extent.z());
}

/// The fitting of a shape that the file names.
class NamedFit {
public:
    NamedFit(ShapeKind kind, const BoundingBox &box, const Eigen::Affine3d &to_device,
             const std::string &label)
        : extent_(box.extent()), half_size_(0.5 * box.extent()), axes_(to_device.linear()),
          scale_(axes_.colwise().norm().transpose()), what_(name_of(kind)), label_(label) {
        placement_ = Eigen::Isometry3d::Identity();
        placement_.translation() = to_device * (box.lower + half_size_);
        require(scale_.minCoeff() > 0.0 && scale_.allFinite(), "its transform flattens it");
        const Matrix3 unit_axes = axes_ * scale_.cwiseInverse().asDiagonal();
        const Matrix3 off_square = unit_axes.transpose() * unit_axes - Matrix3::Identity();
        require(off_square.cwiseAbs().maxCoeff() <= kTransformRounding,
                "its transform shears it; scale along its own axes only");
        placement_.linear() = nearest_rotation(unit_axes);
    }

    [[nodiscard]] contact::AnalyticShape::Size size(ShapeKind kind) {
        switch (kind) {
        case ShapeKind::plate:
            return plate();
        case ShapeKind::sphere:
            return sphere();
        case ShapeKind::box:
            return box();
        case ShapeKind::cylinder:
            return cylinder();
        case ShapeKind::capsule:
            break;
        }
        return capsule();
    }

    [[nodiscard]] const Eigen::Isometry3d &placement() const { return placement_; }

private:
    void require(bool holds, const std::string &otherwise) const {
        if (!holds) {
            throw InputError(label_ + ": cannot be touched as a " + what_ + ": " + otherwise);
        }
    }

    void require_extent(bool holds, const std::string &rule) const {
        require(holds, "its mesh is " + shown(extent_) + "; " + rule);
    }

    /// Mirroring is left out: every shape here is its own mirror image.
    [[nodiscard]] static Matrix3 nearest_rotation(const Matrix3 &axes) {
        return Eigen::Quaterniond(right_handed(axes)).normalized().toRotationMatrix();
    }

    [[nodiscard]] double uniform_scale() const {
        require(scale_.maxCoeff() - scale_.minCoeff() <= kTransformRounding * scale_.maxCoeff(),
                "its transform scales by " + shown(scale_) + "; the three must be the same");
        return scale_.mean();
    }

    void require_round() const {
        const double wider = std::max(extent_.x(), extent_.z());
        require_extent(extent_.y() > 0.0 && wider > 0.0 &&
                           std::abs(extent_.x() - extent_.z()) <= kNamedLikeness * wider,
                       "its x and z must agree within 1 %, and it stands along y");
    }

    [[nodiscard]] contact::AnalyticShape::Size plate() {
        int flat = 0;
        extent_.minCoeff(&flat);
        require_extent(is_flat(half_size_, flat) && (extent_.array() > 0.0).count() >= 2,
                       "one of these must be below 1 % of the largest, and the others not 0");
        const PlacedBox across =
            with_second_axis({placement_, half_size_.cwiseProduct(scale_)}, flat);
        placement_ = across.placement;
        return plate_across(across.half_m);
    }

    [[nodiscard]] contact::AnalyticShape::Size sphere() const {
        require_extent(extent_.maxCoeff() > 0.0 && extent_.maxCoeff() - extent_.minCoeff() <=
                                                       kNamedLikeness * extent_.maxCoeff(),
                       "the three must agree within 1 %");
        return contact::Sphere{half_size_.maxCoeff() * uniform_scale()};
    }

    [[nodiscard]] contact::AnalyticShape::Size box() const {
        require_extent(extent_.minCoeff() > 0.0, "none may be 0; a flat one is a plate");
        return contact::Box{half_size_.cwiseProduct(scale_)};
    }

    [[nodiscard]] contact::AnalyticShape::Size cylinder() const {
        require_round();
        return cylinder_along(half_size_ * uniform_scale());
    }

    [[nodiscard]] contact::AnalyticShape::Size capsule() const {
        require_round();
        const Vector3 half_m = half_size_ * uniform_scale();
        require_extent(half_m.y() >= (1.0 - kNamedLikeness) * radius_within(half_m),
                       "its y must not be less than its x and z");
        return capsule_along(half_m);
    }

    Vector3 extent_;
    Vector3 half_size_;
    Matrix3 axes_;
    Vector3 scale_; ///< metres per unit along each of the mesh's axes
    std::string what_;
    std::string label_;
    Eigen::Isometry3d placement_;
};

/// The triangles of one material.
struct Piece {
    std::vector<Vector3> points_m; ///< corners, and the middles of triangles and edges
    std::vector<Vector3> normals;  ///< of each triangle, as long as twice its area
    std::vector<Vector3> corner_m; ///< the first of each triangle
    double area_m2 = 0.0;

    Piece(const contact::TriangleSoup &soup, std::uint16_t material) {
        for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
            if (soup.material_of_triangle[i] != material) {
                continue;
            }
            const auto &[ia, ib, ic] = soup.triangles[i];
            const Vector3 &a = soup.vertices_m[ia];
            const Vector3 &b = soup.vertices_m[ib];
            const Vector3 &c = soup.vertices_m[ic];
            for (const Vector3 &point :
                 {a, b, c, Vector3((a + b + c) / 3.0), Vector3(0.5 * (a + b)),
                  Vector3(0.5 * (b + c)), Vector3(0.5 * (c + a))}) {
                points_m.push_back(point);
            }
            normals.emplace_back((b - a).cross(c - a));
            corner_m.push_back(a);
            area_m2 += 0.5 * normals.back().norm();
        }
    }

    /// What they enclose, seen from `centre_m`; negative if they face inwards.
    [[nodiscard]] double volume_m3(const Vector3 &centre_m) const {
        double sum = 0.0;
        for (std::size_t i = 0; i < normals.size(); ++i) {
            sum += normals[i].dot(corner_m[i] - centre_m) / 6.0;
        }
        return sum;
    }
};

Matrix3 axes_of_spread(const Piece &piece) {
    Vector3 mean = Vector3::Zero();
    for (const Vector3 &point : piece.points_m) {
        mean += point / static_cast<double>(piece.points_m.size());
    }
    Matrix3 spread = Matrix3::Zero();
    for (const Vector3 &point : piece.points_m) {
        spread += (point - mean) * (point - mean).transpose();
    }
    return principal_axes(spread).eigenvectors;
}

/// The normal of the largest triangle, and of the largest that is square to it.
Matrix3 axes_of_largest_faces(const Piece &piece) {
    const auto largest = std::ranges::max_element(piece.normals, {}, &Vector3::squaredNorm);
    const Vector3 first = largest->normalized();
    Vector3 second = first.unitOrthogonal();
    double second_size = 0.0;
    for (const Vector3 &normal : piece.normals) {
        const bool is_square = std::abs(normal.dot(first)) < kSameDirection * normal.norm();
        if (is_square && normal.norm() > second_size) {
            second_size = normal.norm();
            second = (normal - first * first.dot(normal)).normalized();
        }
    }
    Matrix3 axes;
    axes << first, second, first.cross(second);
    return axes;
}

double size_of(const contact::Plate &plate) { return 4.0 * plate.half_x_m * plate.half_z_m; }
double size_of(const contact::Sphere &sphere) {
    return 4.0 / 3.0 * std::numbers::pi * std::pow(sphere.radius_m, 3);
}
double size_of(const contact::Box &box) { return 8.0 * box.half_size_m.prod(); }
double size_of(const contact::Cylinder &cylinder) {
    return 2.0 * std::numbers::pi * std::pow(cylinder.radius_m, 2) * cylinder.half_height_m;
}
double size_of(const contact::Capsule &capsule) {
    return size_of(contact::Sphere{capsule.radius_m}) +
           size_of(contact::Cylinder{capsule.radius_m, capsule.half_axis_m});
}

/// Tries shapes in one frame after another and keeps the one that deviates least.
class BestShape {
public:
    BestShape(const Piece &piece, contact::TouchSides sides, std::uint16_t material)
        : piece_(piece), sides_(sides), material_(material) {}

    /// @param axes  orthonormal, right-handed
    void try_frame(const Matrix3 &axes) {
        Eigen::AlignedBox3d box;
        for (const Vector3 &point : piece_.points_m) {
            box.extend(Vector3(axes.transpose() * point));
        }
        extent_m_ = box.sizes().maxCoeff();
        Eigen::Isometry3d placement = Eigen::Isometry3d::Identity();
        placement.linear() = axes;
        placement.translation() = axes * box.center();
        for (int y = 0; y < 3; ++y) {
            try_along_y(with_second_axis({placement, 0.5 * box.sizes()}, y));
        }
    }

    [[nodiscard]] const std::optional<RecognisedShape> &get() const { return best_; }

private:
    void try_along_y(const PlacedBox &box) {
        const auto &[placement, half_m] = box;
        if (is_flat(half_m, 1)) {
            if (half_m.x() > 0.0 && half_m.z() > 0.0 && sides_ != contact::TouchSides::one) {
                consider(plate_across(half_m), placement, piece_.area_m2);
            }
            return;
        }
        if (sides_ == contact::TouchSides::two || !(half_m.minCoeff() > 0.0)) {
            return;
        }
        const double volume_m3 = piece_.volume_m3(placement.translation());
        consider(contact::Box{half_m}, placement, volume_m3);
        consider(contact::Sphere{farthest_m(placement.translation())}, placement, volume_m3);
        consider(cylinder_along(half_m), placement, volume_m3);
        if (half_m.y() > (1.0 + kRecognisedLikeness) * radius_within(half_m)) { // else a sphere
            consider(capsule_along(half_m), placement, volume_m3);
        }
    }

    /// The corners of a tessellated ball lie on it, though none may lie at the ends of an axis.
    [[nodiscard]] double farthest_m(const Vector3 &centre_m) const {
        double farthest_m = 0.0;
        for (const Vector3 &point : piece_.points_m) {
            farthest_m = std::max(farthest_m, (point - centre_m).norm());
        }
        return farthest_m;
    }

    template <typename Size>
    void consider(const Size &size, const Eigen::Isometry3d &placement, double requested_size) {
        if (std::abs(size_of(size) - requested_size) > kFullness * size_of(size)) {
            return;
        }
        const contact::AnalyticShape shape(size, placement, material_);
        double deviation_m = 0.0;
        for (const Vector3 &point : piece_.points_m) {
            deviation_m = std::max(deviation_m, std::abs(shape.nearest(point).distance_m));
        }
        // A simpler one is kept unless another is clearly better: the box around a tessellated ball
        // is not quite a cube, and so the ball nearly a capsule.
        constexpr double kBetter = 0.7;
        if (deviation_m <= kRecognisedLikeness * extent_m_ &&
            (!best_ || deviation_m < kBetter * best_->deviation_m - 1e-9)) {
            best_ = RecognisedShape{shape, deviation_m};
        }
    }

    const Piece &piece_;
    contact::TouchSides sides_;
    std::uint16_t material_;
    double extent_m_ = 0.0;
    std::optional<RecognisedShape> best_;
};

} // namespace

std::string name_of(ShapeKind shape) {
    return std::string(kShapeNames[static_cast<std::size_t>(shape)]);
}

contact::AnalyticShape fit_shape(ShapeKind kind, const BoundingBox &box,
                                 const Eigen::Affine3d &to_device, std::uint16_t material,
                                 const std::string &label) {
    NamedFit fit(kind, box, to_device, label);
    const contact::AnalyticShape::Size size = fit.size(kind);
    return {size, fit.placement(), material};
}

std::optional<RecognisedShape> recognise_shape(const contact::TriangleSoup &soup,
                                               std::uint16_t material) {
    const Piece piece(soup, material);
    if (!(piece.area_m2 > 0.0)) {
        return std::nullopt;
    }
    BestShape best(piece, soup.materials[material].sides, material);
    best.try_frame(Matrix3::Identity());
    best.try_frame(right_handed(axes_of_largest_faces(piece)));
    best.try_frame(right_handed(axes_of_spread(piece)));
    return best.get();
}

} // namespace springdrive::scene
