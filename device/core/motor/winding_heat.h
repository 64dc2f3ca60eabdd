// A winding's heat: its temperature and resistance, and what is certain of both from its current
// alone.
#pragma once

#include "device/core/motor/motor.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace springdrive::device {

// A motor's temperature by the two-body thermal network of data sheets, winding to housing to air,
// and the resulting resistance R(T, θ) of (7).
//
//   C_w dT_w/dt = P − (T_w − T_h)/R_wh                     C_w = t_w / R_wh
//   C_h dT_h/dt = (T_w − T_h)/R_wh − (T_h − T_a)/R_ha      C_h = t_m / R_ha
//
// with t_w, t_m the two time constants of the data sheet. Linear, so each update is exact (matrix
// exponential) for a power that is constant over the update.

/// Temperature at which data sheets state R.
inline constexpr double kReferenceTemperature_C = 25.0;

/// R(T, θ) = R [1 + ρ (T − 25 °C)] [1 + c cos(s θ + φ)] (7): copper's temperature coefficient and
/// the commutator's ripple of amplitude c with s segments and the phase φ; of a simulated motor
/// with a second harmonic, too. RT-safe.
[[nodiscard]] double winding_resistance_Ohm(const MotorParameters &motor, double winding_C,
                                            double theta_rad);

/// Minimum of R(T, θ) over all angles, for a winding of at least `winding_C`. RT-safe.
[[nodiscard]] double min_resistance_Ohm(const MotorParameters &motor, double winding_C);

/// Maximum of R(T, θ) over all angles, for a winding of at most `winding_C`. RT-safe.
[[nodiscard]] double max_resistance_Ohm(const MotorParameters &motor, double winding_C);

struct MotorTemperature {
    double winding_C = 0.0;
    double housing_C = 0.0;
};

/// Winding and housing of one motor. RT-safe after construction.
class WindingTemperature {
public:
    /// Winding and housing start at the ambient temperature.
    /// @param period_s  duration of each `update`
    WindingTemperature(const ThermalParameters &thermal, double ambient_C, double period_s);

    /// Sets the duration of each `update` from now on; keeps the temperatures. RT-safe.
    void set_period(double period_s) noexcept;

    /// Advances by one period with the power `heat_W`, R i², in the winding.
    void update(double heat_W) noexcept;

    /// Raises what is colder to these temperatures. RT-safe.
    void raise_to(const MotorTemperature &least) noexcept {
        winding_C_ = std::max(winding_C_, least.winding_C);
        housing_C_ = std::max(housing_C_, least.housing_C);
    }

    [[nodiscard]] MotorTemperature temperature() const { return {winding_C_, housing_C_}; }
    [[nodiscard]] double winding_C() const { return winding_C_; }
    [[nodiscard]] double housing_C() const { return housing_C_; }

private:
    ThermalParameters thermal_;
    double ambient_C_;
    double winding_C_;
    double housing_C_;
    double winding_from_winding_ = 1.0; ///< the network's exponential over a period, row by row
    double winding_from_housing_ = 0.0;
    double housing_from_winding_ = 0.0;
    double housing_from_housing_ = 1.0;
    double winding_K_per_W_ = 0.0; ///< rise over the period per watt
    double housing_K_per_W_ = 0.0;
};

// Lower and upper bounds on a winding's temperature and resistance, and the R̂ that is safe with
// them.
//
// The device has no thermometer, but two bounds follow from the measured current alone, because the
// temperatures of the thermal network above never fall when heat or air
// temperature rise:
//
//   minimum  starts in the coldest air, heated over each tick by the minimum of |i|² times the
//            smallest R(T, θ) at this estimate, which leaves the winding through half of R_wh
//   maximum  starts in the warmest air, heated over each tick by the maximum of |i|² times the
//            largest R(T, θ) at this estimate
//
// If R sags below R̂ (7), the current grows as e^(|dR|t/L). So R̂ is limited to below the smallest
// R of any commutator angle at the lowest possible temperature. On a hot motor R̂ may be larger by
// the rise of R that is certain, and this allowance decreases as the motor cools.
//
// Of R itself it knows the file's value within its tolerance. What an observer of the currents says
// never raises the allowed R̂: it may take the voltage of brushes and bridge for a resistance.
// Observations are intersected, though, so that a sensor that fails later, or a motor that is not
// the file's, contradicts them. Their interval widens by what the air's temperature and a sensor's
// gain may change.
//
// The bounds are as accurate as the device file and the measured current. They assume that between
// two ticks the current changes monotonically, as it does behind a held e_W. A time that nobody
// watched, or that lasts longer than kMaxAtOnce periods, takes the lower bound down to the coldest
// air, and does not lower the upper one.

/// Ambient temperatures for which the device is intended: from a laboratory after a weekend without
/// heating to one on a summer's day. In colder air R would be below what the guard assumes; 15 °C
/// instead of 25 °C costs 0.085 Ω of an RE 25's R̂.
inline constexpr double kColdestAir_C = 15.0;
inline constexpr double kWarmestAir_C = 35.0;

/// By which factor R_wh may differ from a data sheet's, either way.
inline constexpr double kMaxHeatPathFactor = 2.0;

/// The smallest dR of a motor whose R is the file's, and whose windings are only known not to be
/// colder than kColdestAir_C: R at 25 °C minus the R̂ allowed then [Ω].
[[nodiscard]] double min_cold_residual_Ohm(const MotorParameters &motor,
                                           const AmplifierParameters &amplifier);

/// The warmest that motors can be whose windings were never hotter than permitted: at the limit for
/// so long that the housing is in balance with it. The constant current that keeps a winding there
/// is permitted for ever, so a start from here is no stop.
[[nodiscard]] std::array<MotorTemperature, 3>
hottest_motors(const std::array<MotorParameters, 3> &motors);

/// R of a winding as warm as the air, averaged over the commutator's angles, as its amplifier sees
/// it [Ω].
struct ResistanceInterval {
    double min_Ohm = 0.0;
    double max_Ohm = 0.0;

    [[nodiscard]] bool is_empty() const { return !(min_Ohm <= max_Ohm); }
};

/// The guard of one motor. RT-safe after construction.
class WindingGuard {
public:
    /// @param max_cancelled_Ohm  the largest R̂ that the amplifier can be set to
    /// @param period_s           T, the duration of each `update`
    /// @param tolerance          by which share R, as the amplifier sees it, may differ from the
    ///                           file's, either way
    WindingGuard(const MotorParameters &motor, double max_cancelled_Ohm, double period_s,
                 double tolerance = 0.0);

    /// Keeps the estimates. RT-safe.
    void set_period(double period_s) noexcept;

    /// Advances by one period, with the current measured now. A current that is not finite is
    /// unknown: it adds no heat to the lower bound, and that of the amplifier's peak current to the
    /// upper.
    ///
    /// Missed periods before it count as well, each with the maximum of the current for the upper
    /// bound and without heat, in the coldest air, for the lower.
    void update(double current_A, std::uint32_t missed_periods = 0) noexcept;

    /// For a time that is not known, nobody watched. Then the winding is at most as hot as before,
    /// or as `hottest`, and its observed R is that of other air. RT-safe.
    void resume(const MotorTemperature &hottest) noexcept {
        minimum_ = coldest_;
        maximum_.raise_to(hottest);
        forget_observations();
    }

    /// Takes an observation into account, which may contradict those before.
    /// @param observed  contains R unless a sensor is wrong
    void narrow(ResistanceInterval observed) noexcept;

    /// Whether two observations excluded each other, or one the tolerance.
    [[nodiscard]] bool is_contradicted() const { return is_contradicted_; }

    /// Nothing contradicts until the next two observations.
    void forget_observations() noexcept {
        is_observed_ = false;
        is_contradicted_ = false;
    }

    /// The largest R̂ that leaves a net resistance of kMinResidualShare of R at every commutator
    /// angle. That share also covers a winding's cooling while a command is in transit: even the
    /// hottest winding takes more than a tenth of a second to lose as much.
    [[nodiscard]] double max_cancelled_Ohm() const noexcept;

    [[nodiscard]] double min_C() const { return minimum_.winding_C(); }
    [[nodiscard]] double max_C() const { return maximum_.winding_C(); }
    [[nodiscard]] MotorTemperature hottest() const { return maximum_.temperature(); }

private:
    /// Missed periods that are processed one by one, which takes some microseconds.
    static constexpr std::uint32_t kMaxAtOnce = 100;

    [[nodiscard]] double min_Ohm() const noexcept;
    [[nodiscard]] ResistanceInterval tolerated() const noexcept;
    void cool_through(std::uint32_t missed_periods) noexcept;
    void heat_through(std::uint32_t missed_periods, double max_A) noexcept;

    MotorParameters min_;  ///< with the least R
    MotorParameters most_; ///< with the greatest R
    double amplifier_limit_Ohm_;
    double period_s_;
    double margin_Ohm_; ///< of observations
    ResistanceInterval observed_{0.0, 0.0};
    bool is_observed_ = false;
    bool is_contradicted_ = false;
    WindingTemperature coldest_; ///< initial state of `minimum_`
    WindingTemperature minimum_;
    WindingTemperature maximum_;
    double current_A_ = 0.0; ///< at the last update
};

} // namespace springdrive::device
