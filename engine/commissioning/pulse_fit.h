// R, V_b and L of a winding, by test pulses of several voltages.
//
// At ±U the current settles at ±I, but for back-EMF, which drops out of I = (i₊ − i₋)/2:
//
//   U = R I + V_b tanh(I/i_b)
//
// Pulses say U/I and what the current lags behind its final line after the change of sign, by Δi:
//
//   λ = ∫(i + I) dt/(2 I)
//
// i_b is not known and hardly to be found this way: at the lowest level V_b tanh(I/i_b) is V_b
// already, for most. So for each of several i_b, R and V_b follow from all levels by least squares,
// errors being those of R's ripple, R I times its r.m.s. value: pulses act at any angle. Values and
// deviations are those of all i_b, with weights exp(−χ²/2).
//
// L follows from λ. With the back-EMF e at the change of sign, i goes from I − e/R to −I_f, where
// I_f = I + e/R, by (11) with L di/dt = −f(i), f = R (i + I_f) + V_b [tanh(i/i_b) + tanh(I_f/i_b)]:
//
//   L = 2 I λ / ∫ (i + I_f)/f di      without V_b: R λ
//
// Brushes hasten the decay: at U = 4 V_b, U/I λ is 1.12 L, and R λ 0.84 L.
#pragma once

#include "device/core/device_description.h"

#include <array>
#include <cstddef>
#include <limits>
#include <span>

namespace springdrive::commissioning {

/// What pulses of one voltage measured, as the current sensor sees it.
struct PulseLevel {
    double voltage_V = 0.0; ///< U
    double current_A = 0.0; ///< I
    double lag_s = 0.0;     ///< λ
    double emf_V = 0.0;     ///< e
};

/// What a winding would be with one i_b.
struct BrushCurve {
    double brush_A = 0.0; ///< i_b
    double resistance_Ohm = 0.0;
    double voltage_V = 0.0; ///< V_b
    double chi2 = 0.0;
};

inline constexpr std::size_t kBrushCurves = 18; ///< each i_b is 1.19 times the one before

/// NaN without any level.
struct PulseFit {
    double resistance_Ohm = std::numeric_limits<double>::quiet_NaN();
    double resistance_deviation_Ohm = std::numeric_limits<double>::quiet_NaN();
    double brush_V = std::numeric_limits<double>::quiet_NaN(); ///< V_b
    double brush_deviation_V = std::numeric_limits<double>::quiet_NaN();
    double inductance_H = std::numeric_limits<double>::quiet_NaN();
    double inductance_deviation_H = std::numeric_limits<double>::quiet_NaN();
    std::array<BrushCurve, kBrushCurves> curve;
};

[[nodiscard]] PulseFit fit_pulses(const device::MotorParameters &file,
                                  std::span<const PulseLevel> levels);

} // namespace springdrive::commissioning
