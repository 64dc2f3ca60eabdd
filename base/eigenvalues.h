// Eigenvalues and eigenvectors, by functions that are compiled once: Eigen's templates for them
// take a compiler many seconds in every file that uses them.
#pragma once

#include "base/vector.h"

#include <Eigen/Core>

namespace springdrive {

/// Eigenvalues, and eigenvectors as columns.
struct PrincipalAxes {
    Vector3 eigenvalues;
    Matrix3 eigenvectors;
};

struct Modes {
    Eigen::VectorXd eigenvalues;
    Eigen::MatrixXd eigenvectors;
};

// Of symmetric matrices: ascending and orthonormal. Those of three rows do not allocate.
[[nodiscard]] PrincipalAxes principal_axes(const Matrix3 &symmetric);
[[nodiscard]] Vector3 symmetric_eigenvalues(const Matrix3 &symmetric);
[[nodiscard]] Modes symmetric_modes(const Eigen::MatrixXd &symmetric);

/// Of a matrix whose eigenvalues are real.
[[nodiscard]] Modes real_modes(const Eigen::MatrixXd &matrix);

[[nodiscard]] Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd &matrix);

} // namespace springdrive
