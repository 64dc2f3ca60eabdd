// Observes each winding's resistance while the motor is driven, so that R̂ can follow it and dR is
// what was asked for (7).
//
// Over an interval with a held e_W, (1) with (6) integrates to
//
//   ∫e_W dt + R̂ ∫i dt − L Δi = R(T, θ) ∫(i − o) dt + k_T Δθ
//
// with the current i as the amplifier's sensor reads it, and its offset o. Brushes and bridge drop
// V_b tanh(i/i_b) as well, on the right-hand side. The sensor's gain error g scales R and R̂ alike:
// it costs a share g of dR, not of R. An extended Kalman filter estimates
//
//   R(T, θ) = [1 + ρ (T − 25 °C)] [R + Σ aₙ cos(n s θ) + bₙ sin(n s θ)],  n = 1, 2, 4
//   V_b tanh(i/i_b) ≈ Σ V_k tanh(i/i_k),  i_k = 10 to 200 mA,  V_b = Σ V_k
//
// and with it k_T, o, and the rounding of the last angle: counts telescope, so that their error
// does not grow with the number of intervals. T follows from the thermal network in air of 25 °C,
// and from R times the mean square of i, by the same solution of (1), which is not that of its
// mean; that the air is warmer or colder is part of R.
//
// R̂ takes R away, never V_b: at one level of |i| only R + V_b/|i| shows, and R is as unknown as
// V_b/|i|. At two levels they part, far above i_b at once; i_b is not known, so that V_b is a sum
// whose parts are between them. A constant |i| teaches nothing about it, and the variance says so.
//
// An odd number of segments has a ripple of 2 s periods a turn, with a harmonic of its own; any
// other period is noise of what the harmonics were seen to miss, up to the file's amplitude, and
// then R(T, θ) is no better known than that.
//
// Borne as noise are: the ripple of k_T, of which over a window only its ends count,
// k_T (c/s) sin(s θ); e_W that acts δ earlier or later than assumed, by which ∫e_W dt changes by δ
// times its change over the window. k_T drifts with the magnets' heat. Intervals in which R̂ i + e_W
// comes near the supply are skipped: there (6) does not hold.
//
// A device that was calibrated starts from that: R in air of another temperature, k_T, V_b, and
// where the counts' zero is the same, the offset and the ripple. Where the zero was found by eye,
// the ripple's phase is another by δ, normal with a standard deviation of σ at the rotor:
//
//   E[cos n s δ] = e^(−(n s σ)²/2) = f,  E[cos² n s δ] = (1 + f⁴)/2
//
// so its mean fades by f, and its amplitude stays: what the mean loses, the covariance has.
//
// Holding still does not tell the mean R from the commutator's ripple. The variance says so.
//
// A sensor that is stuck, or drifts faster than the filter expects, shows in what was measured
// against what was expected of it. Such intervals teach nothing; if they persist, nothing is
// believed any more. The filter starts again from the file, unseen: only after it has agreed with
// what was measured for some seconds, at R and V_b that it tells apart, which a stuck sensor never
// lets it, is it trusted again. Each further loss of trust doubles that time, until `restart`.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"
#include "device/core/motor/winding_heat.h"

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>

namespace springdrive::control {

// What is known of a motor when its command is computed: what the device file says, or what was
// observed of it.

/// An estimate and its standard deviation.
struct ResistanceEstimate {
    double resistance_Ohm = 0.0;
    double deviation_Ohm = 0.0;
};

/// Resistances are as the amplifier sees them, R/(1 + g).
struct ObservedMotor {
    ResistanceEstimate here; ///< R(T, θ) at the present angle
    ResistanceEstimate mean; ///< averaged over the commutator's angles
    double torque_constant_Nm_per_A = 0.0;
    double offset_A = 0.0; ///< of the current's sensor
    bool is_observed = false;
    bool is_trusted = true;       ///< false: what was measured contradicts the file, or itself
    double brush_voltage_V = 0.0; ///< V_b of brushes and bridge, with the sign of the current
    double brush_deviation_V = 0.0;
    /// The largest R̂ that is passed on to the amplifier, as of the tick before.
    double R_hat_limit_Ohm = std::numeric_limits<double>::infinity();
    /// Slow correction of e_W, along the current of the law's spring, see drive_gains.h.
    double trim_V = 0.0;
    double load = 1.0; ///< whether it carries some of the force that lasts, from 0 to 1, see there
};

using ObservedMotors = std::array<ObservedMotor, 3>;

/// What the file says, which is taken as exact.
[[nodiscard]] constexpr ObservedMotor motor_of_file(const device::MotorParameters &motor) {
    return {.here = {motor.resistance_Ohm, 0.0},
            .mean = {motor.resistance_Ohm, 0.0},
            .torque_constant_Nm_per_A = motor.torque_constant_Nm_per_A};
}

[[nodiscard]] constexpr ObservedMotors
motors_of_file(const std::array<device::MotorParameters, 3> &motor) {
    return {motor_of_file(motor[0]), motor_of_file(motor[1]), motor_of_file(motor[2])};
}

/// k_T of the three motors [N·m/A].
[[nodiscard]] inline Vector3 torque_constants(const ObservedMotors &motors) {
    return {motors[0].torque_constant_Nm_per_A, motors[1].torque_constant_Nm_per_A,
            motors[2].torque_constant_Nm_per_A};
}

/// Their currents without the sensors' offsets [A].
[[nodiscard]] inline Vector3 without_offsets(const Vector3 &measured_A,
                                             const ObservedMotors &motors) {
    return measured_A - Vector3(motors[0].offset_A, motors[1].offset_A, motors[2].offset_A);
}

/// An unknown R may be so many standard deviations lower than it is taken for.
inline constexpr double kHeldUpDeviations = 3.0;

/// The least dR [Ω] that may be asked for with what is known of R: in the coldest air, at any
/// angle, with any V_b and with a file that is wrong by a fifth, less could be an R̂ above R.
[[nodiscard]] constexpr double held_up_dR_Ohm(const ObservedMotor &motor) {
    return motor.is_observed
               ? kHeldUpDeviations * std::max(motor.here.deviation_Ohm, motor.mean.deviation_Ohm)
               : 0.0;
}

/// R̂ [Ω] for the requested dR (7).
[[nodiscard]] constexpr double cancelled_resistance_Ohm(const device::MotorParameters &file,
                                                        const ObservedMotor &motor, double dR_Ohm) {
    const double residual_Ohm = device::residual_resistance_Ohm(file, dR_Ohm);
    return std::max(0.0, motor.here.resistance_Ohm - std::max(residual_Ohm, held_up_dR_Ohm(motor)));
}

/// The dR [Ω] at which the motor is then driven, as far as R is known.
[[nodiscard]] constexpr double acting_dR_Ohm(const device::MotorParameters &file,
                                             const ObservedMotor &motor, double dR_Ohm) {
    const double R_hat_Ohm =
        std::min(cancelled_resistance_Ohm(file, motor, dR_Ohm), motor.R_hat_limit_Ohm);
    return std::max(motor.here.resistance_Ohm - R_hat_Ohm,
                    device::kMinResidualShare * file.resistance_Ohm);
}

/// What happened to one motor between two measurements.
struct DrivenInterval {
    double duration_s = 0.0;
    double e_W_V = 0.0;      ///< mean
    double e_W_step_V = 0.0; ///< by which it changed meanwhile,
    double step_at = 0.0;    ///< after this share of the duration
    double R_hat_Ohm = 0.0;  ///< mean
    double before_A = 0.0;   ///< measured currents at its ends
    double after_A = 0.0;
    double before_rad = 0.0; ///< measured rotor angles at its ends
    double after_rad = 0.0;
};

/// Of the solution of (1) with (6) between the measured currents at its ends [A]. RT-safe.
[[nodiscard]] double mean_current_A(const DrivenInterval &interval, double dR_Ohm,
                                    double inductance_H) noexcept;

/// What is known of a motor before anything is observed, at the angle 0: by the file of its kind,
/// or by its calibration.
[[nodiscard]] ObservedMotor known_at_start(const device::DeviceDescription &device,
                                           std::size_t motor);

/// How long a motor has to be driven on with this current until dR needs no longer be held up [s],
/// if its rotor turns, and |i| varies by a third if V_b is not known; infinite without a current, 0
/// for one that is not trusted. An estimate: one count a window limits what is learned.
[[nodiscard]] double touch_left_s(const device::DeviceDescription &device, std::size_t motor,
                                  const ObservedMotor &known, double dR_Ohm, double current_A);

/// The observer of one motor. RT-safe after construction.
class WindingObserver {
public:
    /// @param device  its calibration is what is known before anything is observed; without one,
    ///                its tolerances
    WindingObserver(const device::DeviceDescription &device, std::size_t motor, double period_s);

    /// Keeps the estimates. RT-safe.
    void set_period(double period_s) noexcept { temperature_.set_period(period_s); }

    /// Takes an interval into account. One in which the amplifier came near the supply is skipped.
    void update(const DrivenInterval &interval) noexcept;

    /// Periods about which only the current is known: the winding's temperature follows.
    void skip(double current_A, std::uint32_t periods = 1) noexcept;

    /// Forgets what was observed, but not the winding's temperature.
    void restart() noexcept;

    /// Forgets it, and is not trusted until what is observed from now on has agreed with itself for
    /// seconds, longer after each time.
    void distrust() noexcept;

    /// From the next `restart` on, the counts' zero is taken to be found by eye.
    void forget_zero() noexcept { has_zero_of_calibration_ = false; }

    /// Whether what was observed has agreed with itself long enough to be relied on: a sensor that
    /// fails while little is known is not noticed at once.
    [[nodiscard]] bool is_settled() const noexcept;

    /// Whether what was measured agrees with what was expected. If not, the estimates are those of
    /// the file.
    [[nodiscard]] bool is_trusted() const noexcept { return is_trusted_; }

    /// k_T and offset are within what the device's tolerances allow.
    [[nodiscard]] ObservedMotor motor(double theta_rad) const noexcept;

    /// The estimate of `at` alone.
    [[nodiscard]] double expected_Ohm(double theta_rad) const noexcept {
        return weights_of_resistance(theta_rad).dot(published());
    }

    /// R(T, θ) as the amplifier sees it: R/(1 + g).
    [[nodiscard]] ResistanceEstimate at(double theta_rad) const noexcept;

    /// The same averaged over the commutator's angles.
    [[nodiscard]] ResistanceEstimate mean() const noexcept;

    /// The mean of a winding as warm as the air.
    [[nodiscard]] ResistanceEstimate unheated() const noexcept;

    /// All that was learned, for air of 25 °C.
    [[nodiscard]] device::MotorCalibration learned() const noexcept;

private:
    static constexpr int kStates = 14;
    using State = Eigen::Matrix<double, kStates, 1>;
    using Covariance = Eigen::Matrix<double, kStates, kStates>;

    /// Of a window.
    struct Noise {
        double voltage_Vs2 = 0.0; ///< variance of what was measured, but of the angle's rounding
        double charge_As2 = 0.0;  ///< variance of the current's integral
        double bias_VAs2 = 0.0;   ///< covariance of the two, reversed
        double ripple_As2 = 0.0;  ///< variance per that of a ripple of R of another period
        double turning = 0.0;     ///< 0: the rotor stands, to 1: by a quarter of a ripple and more
        State of_current;         ///< derivatives of the slope of the voltage over the current
    };

    /// What a window may teach.
    enum class Evidence {
        none,   ///< little current: not R
        of_sum, ///< R, at the level of before: not V_b and the offset
        apart,
    };

    struct Course;

    [[nodiscard]] double warmth() const noexcept;
    [[nodiscard]] State weights_of_resistance(double theta_rad) const noexcept;
    [[nodiscard]] ResistanceEstimate estimate(const State &weights) const noexcept;

    void start_from_file() noexcept;
    void start_from_calibration() noexcept;
    void start_brushes(double mean_V, double variance_V2) noexcept;
    [[nodiscard]] bool is_within_supply(const DrivenInterval &interval,
                                        const Course &course) const noexcept;
    double add_brushes(const Course &course, double duration_s) noexcept;
    void spread_brushes(double variance_V2) noexcept;
    [[nodiscard]] static State brushes() noexcept;
    [[nodiscard]] double mean_square_brush_V2() const noexcept;
    [[nodiscard]] double magnet_fall_per_K() const noexcept;
    [[nodiscard]] const State &published() const noexcept {
        return is_trusted_ ? state_ : file_state_;
    }
    void take_ripple(Eigen::Index harmonic, double cos_Ohm, double sin_Ohm,
                     double deviation_Ohm) noexcept;
    void take_window() noexcept;
    [[nodiscard]] bool had_current() const noexcept;
    void begin_window() noexcept;
    void learn(const State &h, double surprise_Vs, const Noise &noise, Evidence evidence) noexcept;
    void compensate(const Noise &noise, double variance_Vs2) noexcept;
    void forget_rounding() noexcept;
    [[nodiscard]] double max_other_ripple_Ohm2() const noexcept;
    void note_other_ripple(double unexplained_Vs2, double share, const Noise &noise) noexcept;
    void note_surprise(bool is_outlier) noexcept;
    [[nodiscard]] bool is_exactly_known() const noexcept {
        return motor_.resistance_tolerance == 0.0;
    }

    device::MotorParameters motor_;
    device::CurrentSensing sensing_;
    double count_variance_rad2_;
    double current_variance_A2_;
    std::optional<device::MotorCalibration> calibration_;
    double air_variance_K2_ = 0.0; ///< from the calibration's air to the present one
    double zero_by_eye_rad_;       ///< standard deviation, at the rotor
    bool has_zero_of_calibration_ = false;
    device::WindingTemperature temperature_;
    State state_{State::Zero()};
    Covariance covariance_{Covariance::Zero()};
    State file_state_{State::Zero()}; ///< what is known by the file alone
    Covariance file_covariance_{Covariance::Zero()};
    double warmth_before_ = 1.0; ///< at the end of the window before
    double housing_before_C_ = device::kReferenceTemperature_C;
    int settled_windows_ = 0;
    int distrusts_ = 0;              ///< losses of trust since `restart`
    double disbelief_ = 0.0;         ///< in outliers, of late
    double other_ripple_Ohm2_ = 0.0; ///< variance of what the harmonics do not follow
    int other_ripple_shown_ = 0;     ///< how often it was
    bool is_trusted_ = true;

    // Sums over the present window.
    double voltage_Vs_ = 0.0;
    State weights_{State::Zero()}; ///< derivatives by the states, without k_T and rounding
    double current_Vs2_ = 0.0;     ///< variance, by the noise of the currents
    double charge_As2_ = 0.0;      ///< variance of the current's integral, by the same
    double bias_VAs2_ = 0.0;       ///< the same times dR
    State of_noise_{State::Zero()};
    double misfit_s_ = 0.0; ///< deviation from V_b tanh(i/i_b), as a share of V_b, integrated
    double first_e_W_V_ = 0.0;
    double first_R_hat_Ohm_ = 0.0;
    double last_e_W_V_ = 0.0;
    double last_R_hat_Ohm_ = 0.0;
    double asymmetry_s_ = 0.0; ///< ½ less the weight of an interval's first current, integrated
    double first_rate_rad_per_s_ = 0.0;
    double last_rate_rad_per_s_ = 0.0;
    double turned_rad_ = 0.0;
    double window_s_ = 0.0;
    double period_s_ = 0.0;      ///< of its last interval
    double mean_before_A_ = 0.0; ///< current of the window before, without its offset
    double usual_A_ = 0.0;       ///< its magnitude, of late
};

} // namespace springdrive::control
