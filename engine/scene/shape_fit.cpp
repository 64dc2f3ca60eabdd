#include "engine/scene/shape_fit.h"

#include "base/input_error.h"
#include "base/one_line.h"

#include <array>
#include <cmath>

namespace springdrive::scene::gltf {

namespace {

constexpr double kLikeness = 0.01; // what tessellation takes off a round shape's extents

/// What a matrix of single-precision numbers, or a unit quaternion of few digits, may be off.
constexpr double kTransformRounding = 1e-4;

std::string shown(const Vector3 &extent) {
    return shortest_text(extent.x()) + " by " + shortest_text(extent.y()) + " by " +
           shortest_text(extent.z());
}

/// The fitting of one shape.
class ShapeFit {
public:
    ShapeFit(ShapeKind kind, const BoundingBox &box, const Eigen::Affine3d &to_device,
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
        Matrix3 turned = axes;
        if (turned.determinant() < 0.0) {
            turned.col(2) = -turned.col(2);
        }
        return Eigen::Quaterniond(turned).normalized().toRotationMatrix();
    }

    [[nodiscard]] double uniform_scale() const {
        require(scale_.maxCoeff() - scale_.minCoeff() <= kTransformRounding * scale_.maxCoeff(),
                "its transform scales by " + shown(scale_) + "; the three must be the same");
        return scale_.mean();
    }

    void require_round() const {
        const double wider = std::max(extent_.x(), extent_.z());
        require_extent(extent_.y() > 0.0 && wider > 0.0 &&
                           std::abs(extent_.x() - extent_.z()) <= kLikeness * wider,
                       "its x and z must agree within 1 %, and it stands along y");
    }

    [[nodiscard]] contact::AnalyticShape::Size plate() {
        int flat = 0;
        const double thickness = extent_.minCoeff(&flat);
        const int x = (flat + 2) % 3;
        const int z = (flat + 1) % 3;
        require_extent(thickness < kLikeness * extent_.maxCoeff() && extent_[x] > 0.0 &&
                           extent_[z] > 0.0,
                       "one of these must be below 1 % of the largest, and the others not 0");
        const Matrix3 axes = placement_.linear(); // (x, flat, z) is right-handed
        placement_.linear() << axes.col(x), axes.col(flat), axes.col(z);
        return contact::Plate{half_size_[x] * scale_[x], half_size_[z] * scale_[z]};
    }

    [[nodiscard]] contact::AnalyticShape::Size sphere() const {
        require_extent(extent_.maxCoeff() > 0.0 && extent_.maxCoeff() - extent_.minCoeff() <=
                                                       kLikeness * extent_.maxCoeff(),
                       "the three must agree within 1 %");
        return contact::Sphere{half_size_.maxCoeff() * uniform_scale()};
    }

    [[nodiscard]] contact::AnalyticShape::Size box() const {
        require_extent(extent_.minCoeff() > 0.0, "none may be 0; a flat one is a plate");
        return contact::Box{half_size_.cwiseProduct(scale_)};
    }

    [[nodiscard]] contact::AnalyticShape::Size cylinder() const {
        require_round();
        const Vector3 half_m = half_size_ * uniform_scale();
        return contact::Cylinder{std::max(half_m.x(), half_m.z()), half_m.y()};
    }

    [[nodiscard]] contact::AnalyticShape::Size capsule() const {
        require_round();
        const Vector3 half_m = half_size_ * uniform_scale();
        const double radius_m = std::max(half_m.x(), half_m.z());
        require_extent(half_m.y() >= (1.0 - kLikeness) * radius_m,
                       "its y must not be less than its x and z");
        return contact::Capsule{radius_m, std::max(half_m.y() - radius_m, 0.0)};
    }

    Vector3 extent_;
    Vector3 half_size_;
    Matrix3 axes_;
    Vector3 scale_; ///< metres per unit along each of the mesh's axes
    std::string what_;
    std::string label_;
    Eigen::Isometry3d placement_;
};

} // namespace

contact::AnalyticShape fit_shape(ShapeKind kind, const BoundingBox &box,
                                 const Eigen::Affine3d &to_device, std::uint16_t material,
                                 const std::string &label) {
    ShapeFit fit(kind, box, to_device, label);
    const contact::AnalyticShape::Size size = fit.size(kind);
    return {size, fit.placement(), material};
}

} // namespace springdrive::scene::gltf
