#include "engine/lab/model_selection/primitive_fit.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace springdrive::model_selection {

namespace {

constexpr double kLikeness = 0.02;     // of the extent: what is farther off is not even tried
constexpr double kFullness = 0.05;     // of volume or area: what tessellation takes off
constexpr double kFlatness = 0.01;     // of the extent: thinner is a plate
constexpr double kSameDirection = 0.1; // sine of the angle up to which two faces are parallel

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

Matrix3 principal_axes(const Piece &piece) {
    Vector3 mean = Vector3::Zero();
    for (const Vector3 &point : piece.points_m) {
        mean += point / static_cast<double>(piece.points_m.size());
    }
    Matrix3 spread = Matrix3::Zero();
    for (const Vector3 &point : piece.points_m) {
        spread += (point - mean) * (point - mean).transpose();
    }
    return Eigen::SelfAdjointEigenSolver<Matrix3>(spread).eigenvectors();
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
        const Vector3 half_m = 0.5 * box.sizes();
        for (int y = 0; y < 3; ++y) {
            Eigen::Isometry3d placement = Eigen::Isometry3d::Identity();
            placement.linear() << axes.col((y + 2) % 3), axes.col(y), axes.col((y + 1) % 3);
            placement.translation() = axes * box.center();
            try_along_y(placement, {half_m[(y + 2) % 3], half_m[y], half_m[(y + 1) % 3]});
        }
    }

    [[nodiscard]] const std::optional<PrimitiveFit> &get() const { return best_; }

private:
    void try_along_y(const Eigen::Isometry3d &placement, const Vector3 &half_m) {
        if (half_m.y() < 0.5 * kFlatness * extent_m_) {
            if (half_m.x() > 0.0 && half_m.z() > 0.0 && sides_ != contact::TouchSides::one) {
                consider(contact::Plate{half_m.x(), half_m.z()}, placement, piece_.area_m2);
            }
            return;
        }
        if (sides_ == contact::TouchSides::two || !(half_m.minCoeff() > 0.0)) {
            return;
        }
        const double volume_m3 = piece_.volume_m3(placement.translation());
        const double radius_m = std::max(half_m.x(), half_m.z());
        consider(contact::Box{half_m}, placement, volume_m3);
        consider(contact::Sphere{farthest_m(placement.translation())}, placement, volume_m3);
        consider(contact::Cylinder{radius_m, half_m.y()}, placement, volume_m3);
        if (half_m.y() > (1.0 + kLikeness) * radius_m) { // a shorter one is a sphere
            consider(contact::Capsule{radius_m, half_m.y() - radius_m}, placement, volume_m3);
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
    void consider(const Size &size, const Eigen::Isometry3d &placement, double wanted_size) {
        if (std::abs(size_of(size) - wanted_size) > kFullness * size_of(size)) {
            return;
        }
        const contact::AnalyticShape shape(size, placement, material_);
        double deviation_m = 0.0;
        for (const Vector3 &point : piece_.points_m) {
            deviation_m = std::max(deviation_m, std::abs(shape.nearest(point).distance_m));
        }
        // A simpler one keeps its place against what is only a little better: the box round a
        // tessellated ball is not quite a cube, and so the ball nearly a capsule.
        constexpr double kBetter = 0.7;
        if (deviation_m <= kLikeness * extent_m_ &&
            (!best_ || deviation_m < kBetter * best_->deviation_m - 1e-9)) {
            best_ = PrimitiveFit{shape, deviation_m};
        }
    }

    const Piece &piece_;
    contact::TouchSides sides_;
    std::uint16_t material_;
    double extent_m_ = 0.0;
    std::optional<PrimitiveFit> best_;
};

Matrix3 right_handed(Matrix3 axes) {
    if (axes.determinant() < 0.0) {
        axes.col(2) = -axes.col(2);
    }
    return axes;
}

} // namespace

std::optional<PrimitiveFit> fit_primitive(const contact::TriangleSoup &soup,
                                          std::uint16_t material) {
    const Piece piece(soup, material);
    if (!(piece.area_m2 > 0.0)) {
        return std::nullopt;
    }
    BestShape best(piece, soup.materials[material].sides, material);
    best.try_frame(Matrix3::Identity());
    best.try_frame(right_handed(axes_of_largest_faces(piece)));
    best.try_frame(right_handed(principal_axes(piece)));
    return best.get();
}

} // namespace springdrive::model_selection
