// A motor's temperature by the two-body thermal network of data sheets, winding to housing to air,
// and the resulting resistance R(T, θ) of (7).
//
//   C_w dT_w/dt = P − (T_w − T_h)/R_wh                     C_w = t_w / R_wh
//   C_h dT_h/dt = (T_w − T_h)/R_wh − (T_h − T_a)/R_ha      C_h = t_m / R_ha
//
// with t_w, t_m the two time constants of the data sheet. Linear, so each update is exact (matrix
// exponential) for a power that is constant over the update.
#pragma once

#include "device/core/motor/motor.h"

#include <algorithm>

namespace springdrive::device {

/// Temperature at which data sheets state R.
inline constexpr double kReferenceTemperature_C = 25.0;

/// R(T, θ) = R [1 + ρ (T − 25 °C)] [1 + c cos(s θ + φ)] (7): copper's temperature coefficient and
/// the commutator's ripple of amplitude c with s segments and the phase φ. RT-safe.
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

} // namespace springdrive::device
