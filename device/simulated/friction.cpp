#include "device/simulated/friction.h"

#include <cstddef>

namespace springdrive::simulated {

namespace {

template <int joints> using Vector = Eigen::Matrix<double, joints, 1>;
template <int joints> using Matrix = Eigen::Matrix<double, joints, joints>;
template <int joints> using Modes = std::array<FrictionMode, static_cast<std::size_t>(joints)>;

/// The solution for given modes; stopped joints are eliminated from the system.
template <int joints>
Vector<joints> solve_for(const Matrix<joints> &A, const Vector<joints> &b,
                         const JointFrictionRange<joints> &friction, const Modes<joints> &modes) {
    Matrix<joints> system = A;
    Vector<joints> right = b;
    for (Eigen::Index j = 0; j < joints; ++j) {
        const FrictionMode mode = modes[static_cast<std::size_t>(j)];
        if (mode == FrictionMode::stopped) {
            system.row(j).setZero();
            system.col(j).setZero();
            system(j, j) = 1.0;
            right[j] = 0.0;
        } else {
            right[j] +=
                mode == FrictionMode::turning_forward ? friction.minimum[j] : friction.maximum[j];
        }
    }
    Vector<joints> v = solve_definite<joints>(system, right);
    for (Eigen::Index j = 0; j < joints; ++j) {
        if (modes[static_cast<std::size_t>(j)] == FrictionMode::stopped) {
            v[j] = 0.0; // exactly
        }
    }
    return v;
}

/// The mode that a joint should change to; its own if that agrees with the solution.
FrictionMode corrected(FrictionMode mode, double v, double needed, double minimum, double maximum) {
    switch (mode) {
    case FrictionMode::turning_forward:
        return v >= 0.0 ? mode : FrictionMode::stopped;
    case FrictionMode::turning_backward:
        return v <= 0.0 ? mode : FrictionMode::stopped;
    case FrictionMode::stopped:
        break;
    }
    if (needed < minimum) {
        return FrictionMode::turning_forward;
    }
    return needed > maximum ? FrictionMode::turning_backward : FrictionMode::stopped;
}

/// Changes one joint at a time, the first that disagrees: for such a matrix this cannot cycle
/// (Murty's least-index rule), so it ends within the number of combinations.
template <int joints>
Vector<joints> solve(const Matrix<joints> &A, const Vector<joints> &b,
                     const JointFrictionRange<joints> &friction, Modes<joints> &modes) noexcept {
    constexpr int kCombinations = joints == 3 ? 27 : 9;
    Vector<joints> v = Vector<joints>::Zero();
    for (int trial = 0; trial < kCombinations; ++trial) {
        v = solve_for<joints>(A, b, friction, modes);
        const Vector<joints> needed = A * v - b;
        bool agrees = true;
        for (Eigen::Index j = 0; j < joints && agrees; ++j) {
            FrictionMode &mode = modes[static_cast<std::size_t>(j)];
            const FrictionMode better =
                corrected(mode, v[j], needed[j], friction.minimum[j], friction.maximum[j]);
            agrees = better == mode;
            mode = better;
        }
        if (agrees) {
            break;
        }
    }
    return v;
}

} // namespace

Vector3 solve_with_friction(const Matrix3 &A, const Vector3 &b, const FrictionRange &friction,
                            std::array<FrictionMode, 3> &modes) noexcept {
    return solve<3>(A, b, friction, modes);
}

Eigen::Vector2d solve_with_friction(const Eigen::Matrix2d &A, const Eigen::Vector2d &b,
                                    const JointFrictionRange<2> &friction,
                                    std::array<FrictionMode, 2> &modes) noexcept {
    return solve<2>(A, b, friction, modes);
}

} // namespace springdrive::simulated
