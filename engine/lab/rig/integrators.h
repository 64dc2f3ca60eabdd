// Integrators of ẏ = f(t, y) with which the plant's own is compared: one step each, of any system.
// `State` is a fixed-size Eigen vector; nothing allocates.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace springdrive::rig {

/// First order; where f shrinks at the rate λ, stable up to h = 2/λ.
template <typename Rates, typename State>
[[nodiscard]] State explicit_euler_step(const Rates &f, double time_s, const State &y, double h) {
    return y + h * f(time_s, y);
}

/// First order: momenta by the old positions, then positions by the new momenta. The two
/// parts of f are `first` and `second`.
template <typename First, typename Second, typename State>
[[nodiscard]] State semi_implicit_euler_step(const First &first, const Second &second,
                                             double time_s, const State &y, double h) {
    const State kicked = y + h * first(time_s, y);
    return kicked + h * second(time_s, kicked);
}

/// The classical method of fourth order; where f shrinks at the rate λ, stable up to h = 2.785/λ.
template <typename Rates, typename State>
[[nodiscard]] State runge_kutta_step(const Rates &f, double time_s, const State &y, double h) {
    const State k1 = f(time_s, y);
    const State k2 = f(time_s + 0.5 * h, State(y + 0.5 * h * k1));
    const State k3 = f(time_s + 0.5 * h, State(y + 0.5 * h * k2));
    const State k4 = f(time_s + h, State(y + h * k3));
    return y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
}

/// Second order, symmetric, stable wherever the system is:  y₁ = y + h f(t + h/2, (y + y₁)/2).
/// Newton's method with one matrix for many steps.
template <typename State> class ImplicitMidpoint {
public:
    /// Computes f's derivative at (t, y) by differences, for steps of `h`.
    template <typename Rates>
    void prepare(const Rates &f, double time_s, const State &y, double h) {
        Matrix system = Matrix::Identity();
        const State rate = f(time_s, y);
        for (Eigen::Index column = 0; column < y.size(); ++column) {
            const double way = kDifference * std::max(1.0, std::abs(y[column]));
            State shifted = y;
            shifted[column] += way;
            system.col(column) -= 0.5 * h / way * (f(time_s, shifted) - rate);
        }
        newton_.compute(system);
        h_ = h;
    }

    /// y₁, converged to round-off. Nothing where the iterations do not converge.
    template <typename Rates>
    [[nodiscard]] std::optional<State> step(const Rates &f, double time_s, const State &y) const {
        State middle = y;
        double before = std::numeric_limits<double>::infinity();
        for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
            const State gap = y + 0.5 * h_ * f(time_s + 0.5 * h_, middle) - middle;
            const State correction = newton_.solve(gap);
            middle += correction;
            const double moved = correction.cwiseAbs().maxCoeff();
            const double scale = std::max(1.0, middle.cwiseAbs().maxCoeff());
            // Converged where the corrections no longer shrink; a stiff f has more round-off.
            if (moved <= kEpsilon * scale || (moved >= before && moved <= kRoundOff * scale)) {
                return State(2.0 * middle - y);
            }
            before = moved;
        }
        return std::nullopt;
    }

private:
    using Matrix = Eigen::Matrix<double, State::RowsAtCompileTime, State::RowsAtCompileTime>;
    static constexpr int kMaxIterations = 50;
    static constexpr double kDifference = 1e-7;
    static constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
    static constexpr double kRoundOff = 1e-10;

    Eigen::PartialPivLU<Matrix> newton_;
    double h_ = 0.0;
};

} // namespace springdrive::rig
