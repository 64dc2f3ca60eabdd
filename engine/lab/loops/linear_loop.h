// The loop of motors that share a load under a sampled, linear law: docs/design.md, "Sampled forms"
// for any number of motors, near rest. Stability and rendered stiffness over frequency are computed
// here.
//
// Between samples the plant is linear and the servo's command is constant, except for one step
// where the delay has a fraction, so that its motion over a period is exact; the velocity filter
// and the held outputs are difference equations. Together they are one matrix that maps the state
// at one sample to the state at the next, and its eigenvalues decide stability.
//
// The load may have more coordinates than motors: bodies behind a compliant structure, which
// encoders do not see and motors do not drive.
#pragma once

#include "device/core/motor/motor.h"
#include "engine/control/tuning.h"

#include <Eigen/Core>

namespace springdrive::loops {

/// The load: M ẍ = [T i; 0] − B ẋ − K x, and its drives: di/dt = W_i i + W_θ̇ θ̇ + W_u u, with u the
/// servo's command, one for each motor. x begins with the motors' angles θ. Without further
/// coordinates it is θ, and K is to the ground; those of further bodies may be angles or, with M, B
/// and K to match, metres.
struct DrivenLoad {
    Eigen::MatrixXd inertia_kg_m2;             ///< M, symmetric and positive definite
    Eigen::MatrixXd damping_Nms_per_rad;       ///< B
    Eigen::MatrixXd stiffness_Nm_per_rad;      ///< K; springs tie all further bodies
    Eigen::VectorXd torque_Nm_per_A;           ///< the diagonal of T
    Eigen::VectorXd current_rate_per_current;  ///< that of W_i: −dR/L behind a spring drive
    Eigen::VectorXd current_rate_per_velocity; ///< that of W_θ̇: −k_T/L behind a spring drive
    Eigen::VectorXd current_rate_per_command;  ///< that of W_u: 1/L behind a spring drive

    /// All zero: inertia, damping, stiffness and drives are still to be set.
    /// @param coordinates  at least as many as motors
    [[nodiscard]] static DrivenLoad of(Eigen::Index motors, Eigen::Index coordinates);
    [[nodiscard]] static DrivenLoad of(Eigen::Index motors) { return of(motors, motors); }

    /// (11): behind an amplifier that leaves dR of the winding, driven in volts.
    void put_behind_spring_drive(Eigen::Index motor, const device::MotorParameters &parameters,
                                 double dR_Ohm);
    /// Behind an amplifier that controls the current, driven in amperes.
    void put_behind_current_drive(Eigen::Index motor, const device::MotorParameters &parameters,
                                  double bandwidth_rad_per_s);

    [[nodiscard]] Eigen::Index motors() const { return torque_Nm_per_A.size(); }
    [[nodiscard]] Eigen::Index coordinates() const { return inertia_kg_m2.rows(); }
};

/// The load over one period: [x, ẋ, i] after it from [x, ẋ, i, u] before, with u constant.
[[nodiscard]] Eigen::MatrixXd sampled_load(const DrivenLoad &load, double period_s);

/// The load over one period of a servo whose commands are d periods late. For whole d the same as
/// above. Otherwise [x, ẋ, i] after it from [x, ẋ, i, u_old, u_new] before, d = n + f, with
/// u_old = u[k−n−1] active for the first f T and u_new = u[k−n] after that: exact over both parts.
[[nodiscard]] Eigen::MatrixXd sampled_load(const DrivenLoad &load, double period_s,
                                           double delay_periods);

/// The servo's law: u[k] = V v[k] + P θ[k], applied from (k + d) T to (k + d + 1) T, with
/// v[k] = a v[k−1] + (1 − a)(θ[k] − θ[k−1])/T.
struct SampledLaw {
    Eigen::MatrixXd per_velocity; ///< V
    Eigen::MatrixXd per_position; ///< P
    double filter_pole = 0.0;     ///< a
    double period_s = 1e-3;       ///< T
    double delay_periods = 0.0;   ///< d, not negative
};

/// K_P and K_D of (10), and λ of its filter.
struct Gains {
    double K_P_V_per_rad = 0.0;
    double K_D_Vs_per_rad = 0.0;
    double lambda_rad_per_s = 0.0;
};

[[nodiscard]] inline Gains gains_of(const control::Tuning &tuning) {
    return {tuning.K_P_V_per_rad, tuning.K_D_Vs_per_rad, tuning.lambda_rad_per_s};
}

/// How a servo samples: T and d.
struct Sampling {
    double period_s = 1e-3;
    double delay_periods = 0.0;
};

/// (10) under (17), where the law treats the share A of a motion as an error and follows the rest:
/// V = k_T (I − A) − K_D A, P = −K_P A.
[[nodiscard]] SampledLaw drift_compensation(const Eigen::VectorXd &k_T, const Gains &gains,
                                            const Eigen::MatrixXd &A, const Sampling &sampling);

/// Where the states of the map over one period begin: θ leads x, and θ̇ leads ẋ.
struct StateStarts {
    StateStarts(Eigen::Index motors, Eigen::Index coordinates)
        : moved(coordinates), rate(moved + motors), current(rate + coordinates),
          velocity(current + motors), first_held(velocity + motors) {}

    static constexpr Eigen::Index position = 0;
    Eigen::Index moved, rate, current, velocity, first_held;
};

/// The map over one period, for the states
///
///   [ x[k],  θ[k] − θ[k−1],  ẋ[k],  i[k],  v[k−1],  u[k−1] … u[k−⌈d⌉] ]
///
/// each for all motors, x and ẋ for all coordinates. The difference replaces θ[k−1], the same
/// states in other coordinates: so position alone, where nothing pulls it back, can be left out
/// exactly.
/// @param load  the result of `sampled_load` for the law's delay over the time until the next
///              sample: the law's period, the time since the last one, unless a servo is late
[[nodiscard]] Eigen::MatrixXd one_period_map(const Eigen::MatrixXd &load, const SampledLaw &law);

/// Whether law or load, with its K, exert a restoring torque on x in every direction.
[[nodiscard]] bool pulls_on_all_positions(const Eigen::MatrixXd &per_position,
                                          const Eigen::MatrixXd &stiffness_Nm_per_rad);

/// The largest |eigenvalue| of that map: the factor by which the slowest mode decays or grows in a
/// period. In directions in which neither the law nor a spring pulls on θ, the motors may rest
/// anywhere, and further bodies with them; their eigenvalues of exactly 1 do not count.
/// @param stiffness_Nm_per_rad  K of the load
[[nodiscard]] double largest_eigenvalue(const Eigen::MatrixXd &map, const SampledLaw &law,
                                        const Eigen::MatrixXd &stiffness_Nm_per_rad);

/// Round-off of 1 − |λ| for a mode that neither grows nor decays.
inline constexpr double kEigenvalueRoundOff = 1e-10;

/// A load discretised for one sampling, to be tried under many laws.
class LinearLoop {
public:
    LinearLoop(DrivenLoad load, const Sampling &sampling);

    [[nodiscard]] const DrivenLoad &load() const { return load_; }
    [[nodiscard]] const Sampling &sampling() const { return sampling_; }

    // For a law with that sampling, which is asserted.
    [[nodiscard]] Eigen::MatrixXd one_period_map(const SampledLaw &law) const;
    [[nodiscard]] double largest_eigenvalue(const SampledLaw &law) const;
    /// Whether every motion decays.
    [[nodiscard]] bool is_stable(const SampledLaw &law) const {
        return largest_eigenvalue(law) < 1.0 - kEigenvalueRoundOff;
    }

private:
    DrivenLoad load_;
    Sampling sampling_;
    Eigen::MatrixXd sampled_load_;
};

/// −τ/θ of all motors over frequency, while each turns at ω alone [N·m/rad]:
///
///   K_m = −T (jω − W_i)⁻¹ [ W_θ̇ jω + W_u H(jω) (V D(e^(jωT)) + P) ]
///   H(jω) = e^(−jωdT) (1 − e^(−jωT))/(jωT),   D(z) = (1 − a)(1 − z⁻¹)/(T (1 − a z⁻¹))
///
/// Of the load only the drives enter.
[[nodiscard]] Eigen::MatrixXcd motor_stiffness(const DrivenLoad &load, const SampledLaw &law,
                                               double omega_rad_per_s);

/// The stiffness of load and law for motions so slow that the currents follow: K plus the static
/// torque that P commands [N·m/rad], of all coordinates.
[[nodiscard]] Eigen::MatrixXd static_stiffness(const DrivenLoad &load, const SampledLaw &law);

/// ω² of the modes of M under that stiffness; negative where they grow.
[[nodiscard]] Eigen::VectorXd static_squares(const DrivenLoad &load, const SampledLaw &law);

} // namespace springdrive::loops
