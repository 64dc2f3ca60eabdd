// Optimality conditions of a place of rest, checked against every triangle by brute force.
#pragma once

#include "tests/engine/contact/mesh/soups.h"

#include <Eigen/LU>

#include <cmath>
#include <cstddef>
#include <vector>

namespace springdrive::testing {

inline Vector3 nearest_on_segment(const Vector3 &p, const Vector3 &a, const Vector3 &b) {
    return a + std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0) * (b - a);
}

inline Vector3 nearest_on(const Corners &triangle, const Vector3 &p) {
    const Vector3 weights = foot_coordinates(triangle, p);
    if (weights.minCoeff() >= 0.0) {
        return weights[0] * triangle[0] + weights[1] * triangle[1] + weights[2] * triangle[2];
    }
    Vector3 best = nearest_on_segment(p, triangle[0], triangle[1]);
    for (std::size_t i = 1; i < 3; ++i) {
        const Vector3 other = nearest_on_segment(p, triangle[i], triangle[(i + 1) % 3]);
        best = (other - p).squaredNorm() < (best - p).squaredNorm() ? other : best;
    }
    return best;
}

/// Directions in which triangles push a proxy that comes within `within_m` of touching them.
inline std::vector<Vector3> pushes(const contact::TriangleSoup &soup, const Vector3 &proxy_m,
                                   double reach_m, double within_m) {
    std::vector<Vector3> normals;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        const Vector3 gap = proxy_m - nearest_on(corners(soup, i), proxy_m);
        if (gap.norm() <= reach_m + within_m) {
            normals.push_back(gap.normalized());
        }
    }
    return normals;
}

/// How much of `gap_m`, from the tip to the proxy, is not a positive sum of the pushes: the
/// remainder with the best three of them [m]. Zero at an optimum (Karush, Kuhn, Tucker).
inline double unexplained_m(const Vector3 &gap_m, const std::vector<Vector3> &normals) {
    double minimum = gap_m.norm();
    const std::size_t n = normals.size();
    const auto consider = [&](const Eigen::Matrix<double, 3, Eigen::Dynamic> &active) {
        const Eigen::VectorXd lambda = active.fullPivLu().solve(gap_m);
        if (lambda.minCoeff() >= 0.0) {
            minimum = std::min(minimum, (active * lambda - gap_m).norm());
        }
    };
    for (std::size_t i = 0; i < n; ++i) {
        // The part along one normal is its projection; along two, that on the plane they span.
        const double along = normals[i].dot(gap_m);
        minimum = along > 0.0 ? std::min(minimum, (gap_m - along * normals[i]).norm()) : minimum;
        for (std::size_t j = i + 1; j < n; ++j) {
            Eigen::Matrix<double, 3, 2> two;
            two << normals[i], normals[j];
            const Eigen::Matrix2d gram = two.transpose() * two;
            if (gram.determinant() > 1e-18) {
                const Eigen::Vector2d lambda = gram.inverse() * (two.transpose() * gap_m);
                if (lambda.minCoeff() >= 0.0) {
                    minimum = std::min(minimum, (two * lambda - gap_m).norm());
                }
            }
            for (std::size_t k = j + 1; k < n; ++k) {
                Matrix3 three;
                three << normals[i], normals[j], normals[k];
                if (std::abs(three.determinant()) > 1e-12) {
                    consider(three);
                }
            }
        }
    }
    return minimum;
}

/// Whether a straight motion goes through a triangle, by the signs of the volumes it spans with
/// the edges.
inline bool crosses(const Corners &triangle, const Vector3 &from, const Vector3 &to) {
    const auto volume = [](const Vector3 &a, const Vector3 &b, const Vector3 &c, const Vector3 &d) {
        return (b - a).cross(c - a).dot(d - a);
    };
    const auto &[a, b, c] = triangle;
    if (volume(a, b, c, from) * volume(a, b, c, to) > 0.0) {
        return false;
    }
    const double u = volume(from, to, a, b);
    const double v = volume(from, to, b, c);
    const double w = volume(from, to, c, a);
    return (u > 0.0 && v > 0.0 && w > 0.0) || (u < 0.0 && v < 0.0 && w < 0.0);
}

} // namespace springdrive::testing
