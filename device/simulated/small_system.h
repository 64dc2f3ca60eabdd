// Solves systems of two or three equations by elimination without pivoting.
#pragma once

#include <Eigen/Core>

namespace springdrive::simulated {

/// The x with A x = b, where A has a positive definite symmetric part, so that every pivot is
/// positive. Not finite if A is singular. RT-safe.
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

} // namespace springdrive::simulated
