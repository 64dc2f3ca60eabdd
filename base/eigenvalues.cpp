#include "base/eigenvalues.h"

#include <Eigen/Eigenvalues>

namespace springdrive {

PrincipalAxes principal_axes(const Matrix3 &symmetric) {
    const Eigen::SelfAdjointEigenSolver<Matrix3> solver(symmetric);
    return {solver.eigenvalues(), solver.eigenvectors()};
}

Vector3 symmetric_eigenvalues(const Matrix3 &symmetric) {
    return Eigen::SelfAdjointEigenSolver<Matrix3>(symmetric, Eigen::EigenvaluesOnly).eigenvalues();
}

Modes symmetric_modes(const Eigen::MatrixXd &symmetric) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(symmetric);
    return {solver.eigenvalues(), solver.eigenvectors()};
}

Modes real_modes(const Eigen::MatrixXd &matrix) {
    const Eigen::EigenSolver<Eigen::MatrixXd> solver(matrix);
    return {solver.eigenvalues().real(), solver.pseudoEigenvectors()};
}

Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd &matrix) { return matrix.eigenvalues(); }

} // namespace springdrive
