// Observes each winding's resistance while the motor is driven, so that R̂ can follow it and dR is
// what was asked for (7).
//
// Over an interval with a held e_W, (1) with (6) integrates to
//
//   ∫e_W dt + R̂ ∫i dt − L Δi = R(T, θ) ∫(i − o) dt + k_T Δθ
//
// with the current i as the amplifier's sensor reads it, and its offset o. The sensor's gain error
// g scales R and R̂ alike: it costs a share g of dR, not of R. An extended Kalman filter estimates
//
//   R(T, θ) = [1 + ρ (T − 25 °C)] [R + Σ aₙ cos(n s θ) + bₙ sin(n s θ)],  n = 1, 2
//
// and with it k_T, o, and the rounding of the last angle: counts telescope, so that their error
// does not grow with the number of intervals. T follows from the thermal network in air of 25 °C;
// that the air is warmer or colder is part of R.
//
// Holding still does not tell the mean R from the commutator's ripple. The variance says so.
#pragma once

#include "device/core/device_file.h"
#include "device/core/motor/winding_temperature.h"

#include <Eigen/Core>

namespace springdrive::control {

/// What happened to one motor between two measurements.
struct DrivenInterval {
    double duration_s = 0.0;
    double e_W_V = 0.0;     ///< mean
    double R_hat_Ohm = 0.0; ///< mean
    double before_A = 0.0;  ///< measured currents at its ends
    double after_A = 0.0;
    double before_rad = 0.0; ///< measured rotor angles at its ends
    double after_rad = 0.0;
};

/// An estimate and its standard deviation.
struct ResistanceEstimate {
    double resistance_Ohm = 0.0;
    double deviation_Ohm = 0.0;
};

/// The observer of one motor. RT-safe after construction.
class ResistanceObserver {
public:
    /// @param device  its tolerances are what is known before anything is observed
    ResistanceObserver(const device::DeviceDescription &device, std::size_t motor, double period_s);

    /// Keeps the estimates. RT-safe.
    void set_period(double period_s) noexcept { temperature_.set_period(period_s); }

    /// Takes an interval into account in which the amplifier was within its limits.
    void update(const DrivenInterval &interval) noexcept;

    /// R(T, θ) as the amplifier sees it: R/(1 + g).
    [[nodiscard]] ResistanceEstimate at(double theta_rad) const noexcept;

    /// The same averaged over the commutator's angles.
    [[nodiscard]] ResistanceEstimate mean() const noexcept;

private:
    static constexpr int kStates = 8;
    using State = Eigen::Matrix<double, kStates, 1>;
    using Covariance = Eigen::Matrix<double, kStates, kStates>;

    [[nodiscard]] double warmth() const noexcept;
    [[nodiscard]] State weights_of_resistance(double theta_rad) const noexcept;
    [[nodiscard]] ResistanceEstimate estimate(const State &weights) const noexcept;

    void take_window() noexcept;

    device::MotorParameters motor_;
    double count_variance_rad2_;
    double current_variance_A2_;
    device::WindingTemperature temperature_;
    State state_{State::Zero()};
    Covariance covariance_{Covariance::Zero()};

    // Sums over the present window.
    double voltage_Vs_ = 0.0;
    State weights_{State::Zero()}; ///< derivatives by the states, without k_T and rounding
    double current_Vs2_ = 0.0;     ///< variance, by the noise of the currents
    double turned_rad_ = 0.0;
    double window_s_ = 0.0;
};

} // namespace springdrive::control
