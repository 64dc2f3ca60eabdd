// Coulomb friction with exact sticking, for an implicit step of three joints or two.
//
// Friction opposes motion with at most τ_c. Over a step, a joint that turns may be braked or
// stopped, or reversed by the load without friction; a joint at rest may be held:
//
//   rate before    friction torque may be      v > 0 after    v = 0 after     v < 0 after
//   > 0            −τ_c … 0                    −τ_c           anything         0
//   = 0            −τ_c … τ_c                  −τ_c           of these         +τ_c
//   < 0            0 … τ_c                     0                               +τ_c
//
// So friction never adds energy over a step, and v = 0 is reached and maintained exactly.
#pragma once

#include "base/vector.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>

namespace springdrive::simulated {

/// The x with A x = b, by elimination without pivoting, where A has a positive definite symmetric
/// part, so that every pivot is positive. Not finite if A is singular. RT-safe.
template <int size>
[[nodiscard]] inline Eigen::Matrix<double, size, 1>
solve_definite(Eigen::Matrix<double, size, size> A, Eigen::Matrix<double, size, 1> b) {
    Eigen::Matrix<double, size, 1> pivot_inverse;
    for (int pivot = 0; pivot < size; ++pivot) {
        pivot_inverse[pivot] = 1.0 / A(pivot, pivot);
        for (int row = pivot + 1; row < size; ++row) {
            const double share = A(row, pivot) * pivot_inverse[pivot];
            for (int column = pivot + 1; column < size; ++column) {
                A(row, column) -= share * A(pivot, column);
            }
            b[row] -= share * b[pivot];
        }
    }
    for (int row = size - 1; row >= 0; --row) {
        for (int column = row + 1; column < size; ++column) {
            b[row] -= A(row, column) * b[column];
        }
        b[row] *= pivot_inverse[row];
    }
    return b;
}

/// The range of friction over a step, per joint [N·m, or N·m·s for an impulse].
template <int joints> struct JointFrictionRange {
    using Vector = Eigen::Matrix<double, joints, 1>;
    Vector minimum{Vector::Zero()};
    Vector maximum{Vector::Zero()};

    /// By the table at the top of this file.
    [[nodiscard]] static JointFrictionRange after(const Vector &rate_before,
                                                  const Vector &coulomb) {
        JointFrictionRange range;
        for (Eigen::Index j = 0; j < joints; ++j) {
            range.minimum[j] = rate_before[j] < 0.0 ? 0.0 : -coulomb[j];
            range.maximum[j] = rate_before[j] > 0.0 ? 0.0 : coulomb[j];
        }
        return range;
    }
};
using FrictionRange = JointFrictionRange<3>;

enum class FrictionMode : std::uint8_t { stopped, turning_forward, turning_backward };

/// The v with A v = b + f where every fⱼ lies in its range: at its lowest where vⱼ > 0, at its
/// highest where vⱼ < 0. It is unique if A has a positive definite symmetric part.
/// @param modes  initial guess and result; the last step's modes are the best guess
/// RT-safe: at most 27 solutions of a 3 × 3 system.
[[nodiscard]] Vector3 solve_with_friction(const Matrix3 &A, const Vector3 &b,
                                          const FrictionRange &friction,
                                          std::array<FrictionMode, 3> &modes) noexcept;

/// The same for two joints: at most 9 solutions of a 2 × 2 system.
[[nodiscard]] Eigen::Vector2d solve_with_friction(const Eigen::Matrix2d &A,
                                                  const Eigen::Vector2d &b,
                                                  const JointFrictionRange<2> &friction,
                                                  std::array<FrictionMode, 2> &modes) noexcept;

} // namespace springdrive::simulated
