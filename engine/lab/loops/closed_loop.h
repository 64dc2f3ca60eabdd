// Stability of motors that share a load under a sampled, linear law: DESIGN section 4 for any
// number of motors, near rest.
//
// Between samples the plant is linear and what the servo commands stands still, but for one step
// where the delay has a fraction, so that its motion over a period is exact; the velocity filter
// and the held outputs are difference equations. Together they are one matrix that takes the state
// at one sample to the state at the next, and its eigenvalues decide.
#pragma once

#include <Eigen/Core>

namespace springdrive::loops {

/// What moves, in motor coordinates: M θ̈ = T i − B θ̇ − K θ, and what drives it:
/// di/dt = W_i i + W_θ̇ θ̇ + W_u u, with u the servo's command, one for each motor.
struct DrivenLoad {
    Eigen::MatrixXd inertia_kg_m2;             ///< M, symmetric and positive definite
    Eigen::MatrixXd damping_Nms_per_rad;       ///< B
    Eigen::MatrixXd stiffness_Nm_per_rad;      ///< K, to the ground
    Eigen::VectorXd torque_Nm_per_A;           ///< the diagonal of T
    Eigen::VectorXd current_rate_per_current;  ///< that of W_i: −dR/L behind a spring drive
    Eigen::VectorXd current_rate_per_velocity; ///< that of W_θ̇: −k_T/L behind a spring drive
    Eigen::VectorXd current_rate_per_command;  ///< that of W_u: 1/L behind a spring drive

    [[nodiscard]] Eigen::Index motors() const { return torque_Nm_per_A.size(); }
};

/// The load over one period: [θ, θ̇, i] after it from [θ, θ̇, i, u] before, u standing still.
[[nodiscard]] Eigen::MatrixXd sampled_load(const DrivenLoad &load, double period_s);

/// The load over one period of a servo whose commands come d late. For whole d the same as above.
/// Else [θ, θ̇, i] after it from [θ, θ̇, i, u_old, u_new] before, d = n + f, with u_old = u[k−n−1] in
/// force for the first f T and u_new = u[k−n] from then on: exact over both parts.
[[nodiscard]] Eigen::MatrixXd sampled_load(const DrivenLoad &load, double period_s,
                                           double delay_periods);

/// What the servo does with what it reads: u[k] = V v[k] + P θ[k], applied from (k + d) T to
/// (k + d + 1) T, with v[k] = a v[k−1] + (1 − a)(θ[k] − θ[k−1])/T.
struct SampledLaw {
    Eigen::MatrixXd per_velocity; ///< V
    Eigen::MatrixXd per_position; ///< P
    double filter_pole = 0.0;     ///< a
    double period_s = 1e-3;       ///< T
    double delay_periods = 0.0;   ///< d, not negative
};

/// The map over one period, for the states
///
///   [ θ[k],  θ[k] − θ[k−1],  θ̇[k],  i[k],  v[k−1],  u[k−1] … u[k−⌈d⌉] ]
///
/// each for all motors. The difference stands in the place of θ[k−1], the same states in other
/// coordinates: so position alone, where nothing pulls it back, can be left out exactly.
/// @param load  as `sampled_load` gives it for the law's period and delay
[[nodiscard]] Eigen::MatrixXd one_period_map(const Eigen::MatrixXd &load, const SampledLaw &law);

/// Whether law or load, with its K, pull back on θ in every direction.
[[nodiscard]] bool pulls_on_all_positions(const Eigen::MatrixXd &per_position,
                                          const Eigen::MatrixXd &stiffness_Nm_per_rad);

/// The largest |eigenvalue| of that map: by how much the slowest mode shrinks or grows in a period.
/// In directions in which neither the law nor a spring pulls on θ, the motors may rest anywhere;
/// their eigenvalues of exactly 1 do not count.
/// @param stiffness_Nm_per_rad  K of the load
[[nodiscard]] double largest_eigenvalue(const Eigen::MatrixXd &map, const SampledLaw &law,
                                        const Eigen::MatrixXd &stiffness_Nm_per_rad);

/// What is left of 1 − |λ| by round-off where a mode neither grows nor dies.
inline constexpr double kEigenvalueRoundOff = 1e-10;

} // namespace springdrive::loops
