#include "device/simulated/friction.h"

#include <Eigen/LU>

#include <cstddef>

namespace springdrive {

namespace {

using Modes = std::array<FrictionMode, 3>;

/// The solution for given modes; stopped joints are taken out of the system.
Vector3 solve_for(const Matrix3 &A, const Vector3 &b, const FrictionRange &friction,
                  const Modes &modes) {
    Matrix3 system = A;
    Vector3 right = b;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const FrictionMode mode = modes[static_cast<std::size_t>(j)];
        if (mode == FrictionMode::stopped) {
            system.row(j).setZero();
            system.col(j).setZero();
            system(j, j) = 1.0;
            right[j] = 0.0;
        } else {
            right[j] +=
                mode == FrictionMode::turning_forward ? friction.lowest[j] : friction.highest[j];
        }
    }
    Vector3 v = system.partialPivLu().solve(right);
    for (Eigen::Index j = 0; j < 3; ++j) {
        if (modes[static_cast<std::size_t>(j)] == FrictionMode::stopped) {
            v[j] = 0.0; // to the last bit
        }
    }
    return v;
}

/// The mode that joint j should change to; its own where it agrees with the solution.
FrictionMode corrected(FrictionMode mode, double v, double needed, double lowest, double highest) {
    switch (mode) {
    case FrictionMode::turning_forward:
        return v >= 0.0 ? mode : FrictionMode::stopped;
    case FrictionMode::turning_backward:
        return v <= 0.0 ? mode : FrictionMode::stopped;
    case FrictionMode::stopped:
        break;
    }
    if (needed < lowest) {
        return FrictionMode::turning_forward;
    }
    return needed > highest ? FrictionMode::turning_backward : FrictionMode::stopped;
}

} // namespace

FrictionRange FrictionRange::after(const Vector3 &rate_before, const Vector3 &coulomb) {
    FrictionRange range;
    for (Eigen::Index j = 0; j < 3; ++j) {
        range.lowest[j] = rate_before[j] < 0.0 ? 0.0 : -coulomb[j];
        range.highest[j] = rate_before[j] > 0.0 ? 0.0 : coulomb[j];
    }
    return range;
}

Vector3 solve_with_friction(const Matrix3 &A, const Vector3 &b, const FrictionRange &friction,
                            std::array<FrictionMode, 3> &modes) noexcept {
    // One joint at a time, the first that disagrees: for a matrix of this kind that cannot cycle
    // (Murty's least-index rule), so it ends within the 27 combinations that there are.
    constexpr int kCombinations = 27;
    Vector3 v = Vector3::Zero();
    for (int trial = 0; trial < kCombinations; ++trial) {
        v = solve_for(A, b, friction, modes);
        const Vector3 needed = A * v - b;
        bool agrees = true;
        for (Eigen::Index j = 0; j < 3 && agrees; ++j) {
            FrictionMode &mode = modes[static_cast<std::size_t>(j)];
            const FrictionMode better =
                corrected(mode, v[j], needed[j], friction.lowest[j], friction.highest[j]);
            agrees = better == mode;
            mode = better;
        }
        if (agrees) {
            break;
        }
    }
    return v;
}

} // namespace springdrive
