// The plant of device/simulated/simulated_phantom.h as a smooth differential equation ẏ = f(t, y),
// for integrators other than its own, which are here too. With y = (q, q̇, i):
//
//   M(q) q̈ = N k_T i − C q̇ − g − b q̇ + Jᵀ F       rotors and the hand's mass in M, J = ∂x/∂q
//   L di/dt = e_W − dR i − k_T N q̇                                                        (11)
//   F = k (x_target − x) + b_hand (ẋ_target − ẋ)
//
// Coulomb friction takes τ_c sign(q̇) from the first, or τ_c tanh(q̇/width) where a method needs it
// smooth. There is no stop, no limit and no ripple, and R stands at 25 °C.
//
// Pure functions over values, no allocation. Every sine is computed once per call, so that the cost
// measured is the integrator's.
#pragma once

#include "device/core/device_description.h"
#include "device/core/haptic_device.h"
#include "device/core/phantom/dynamics.h"
#include "device/simulated/simulation_options.h"

#include <Eigen/Core>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace springdrive::rig {

// Integrators of ẏ = f(t, y) with which the plant's own is compared: one step each, of any system.
// `State` is a fixed-size Eigen vector; nothing allocates.

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

/// (q, q̇, i) [rad, rad/s, A].
using PlantState = Eigen::Matrix<double, 9, 1>;

/// Inputs held over a servo period. The hand's target moves uniformly from `start_s`.
struct PlantInputs {
    device::DeviceCommand command;
    double start_s = 0.0;
    simulated::HandTarget target;
};

/// M(q) is of one joint and of two.
struct PlantInertia {
    double axial_kg_m2 = 0.0;
    double two_kg_m2 = 0.0;
    double three_kg_m2 = 0.0;
    double coupling_kg_m2 = 0.0;

    [[nodiscard]] Vector3 acceleration(const Vector3 &torque_Nm) const;
    [[nodiscard]] Matrix3 matrix_kg_m2() const;
};

/// M(q) q̈ = τ, without Coulomb friction.
struct PlantMechanics {
    PlantInertia inertia;
    Vector3 torque_Nm{Vector3::Zero()};
};

class PlantEquations {
public:
    /// Of `options`, hand, gravity and friction count.
    PlantEquations(const device::DeviceDescription &device,
                   const simulated::SimulationOptions &options);

    /// Sets the inputs of f.
    void set_inputs(const PlantInputs &inputs);

    /// Sets the range of rates over which Coulomb friction reverses; 0, the default, for a jump.
    void set_friction_width(double width_rad_per_s);

    /// f(t, y).
    [[nodiscard]] PlantState rates(double time_s, const PlantState &y) const;

    /// Its part (0, q̈, 0), and the rest of it, (q̇, 0, di/dt).
    [[nodiscard]] PlantState momentum_rates(double time_s, const PlantState &y) const;
    [[nodiscard]] PlantState position_rates(const PlantState &y) const;

    [[nodiscard]] PlantMechanics mechanics(double time_s, const PlantState &y) const;
    [[nodiscard]] const Vector3 &coulomb_Nm() const { return coulomb_Nm_; }

    /// Force of the motors at the tip, J⁻ᵀ N k_T i [N].
    [[nodiscard]] Vector3 tip_force_N(const PlantState &y) const;

private:
    [[nodiscard]] Vector3 acceleration(double time_s, const PlantState &y) const;
    [[nodiscard]] Vector3 friction_Nm(const Vector3 &rate_rad_per_s) const;

    device::PhantomGeometry geometry_;
    device::HandParameters hand_;
    device::LinkageMoments moments_; ///< with the hand's mass at the tip, without its weight
    Vector3 rotor_kg_m2_{Vector3::Zero()};
    Vector3 torque_Nm_per_A_{Vector3::Zero()}; ///< N k_T, also in V·s/rad
    Vector3 resistance_Ohm_{Vector3::Zero()};
    Vector3 inductance_H_{Vector3::Zero()};
    double gravity_m_per_s2_ = 0.0;
    double viscous_Nms_per_rad_ = 0.0;
    Vector3 coulomb_Nm_{Vector3::Zero()};
    bool has_coulomb_ = false;
    double friction_width_rad_per_s_ = 0.0;
    PlantInputs inputs_;
};

} // namespace springdrive::rig
