#include "engine/commissioning/pulse_fit.h"

#include "engine/commissioning/brush_fit.h"

#include <algorithm>
#include <cmath>

namespace springdrive::commissioning {

namespace {

/// Of a voltage, beside ripple: the bridge's, and a current's quantum times R.
constexpr double kVoltageError_V = 2e-3;

/// L for one i_b.
double inductance_H(const BrushCurve &curve, const PulseLevel &level) {
    constexpr int kSteps = 100;
    const double I_A = level.current_A;
    const double final_A = I_A + level.emf_V / curve.resistance_Ohm; // I_f
    const double final_V = curve.voltage_V * std::tanh(final_A / curve.brush_A);
    double integral_S = 0.0; // ∫(i + I_f)/f di over 2 I [1/Ω]
    for (int step = 0; step < kSteps; ++step) {
        const double above_A = 2.0 * I_A * (step + 0.5) / kSteps; // i + I_f
        const double f_V = curve.resistance_Ohm * above_A + final_V +
                           curve.voltage_V * std::tanh((above_A - final_A) / curve.brush_A);
        integral_S += above_A / f_V / kSteps;
    }
    return level.lag_s / integral_S;
}

/// R and V_b for one i_b: V_b as known from the file, between 0 and its greatest.
BrushCurve solved(const device::MotorParameters &file, std::span<const PulseLevel> levels,
                  double brush_A, double &resistance_variance, double &voltage_variance) {
    const double ripple = file.commutation_ripple / std::sqrt(2.0);
    double II = 0.0;
    double It = 0.0;
    double tt = std::pow(std::max(file.max_brush_voltage_V, 1e-9), -2.0);
    double UI = 0.0;
    double Ut = 0.0;
    const auto weight_of = [&](const PulseLevel &level) {
        return 1.0 / (std::pow(ripple * file.resistance_Ohm * level.current_A, 2) +
                      kVoltageError_V * kVoltageError_V);
    };
    for (const PulseLevel &level : levels) {
        const double weight = weight_of(level);
        const double t = std::tanh(level.current_A / brush_A);
        II += weight * level.current_A * level.current_A;
        It += weight * level.current_A * t;
        tt += weight * t * t;
        UI += weight * level.voltage_V * level.current_A;
        Ut += weight * level.voltage_V * t;
    }
    const double determinant = II * tt - It * It;
    BrushCurve curve{brush_A, 0.0, (II * Ut - It * UI) / determinant, 0.0};
    curve.voltage_V = std::clamp(curve.voltage_V, 0.0, file.max_brush_voltage_V);
    curve.resistance_Ohm = (UI - It * curve.voltage_V) / II;
    resistance_variance = tt / determinant;
    voltage_variance = II / determinant;
    for (const PulseLevel &level : levels) {
        const double left_V = level.voltage_V - curve.resistance_Ohm * level.current_A -
                              curve.voltage_V * std::tanh(level.current_A / brush_A);
        curve.chi2 += weight_of(level) * left_V * left_V;
    }
    return curve;
}

} // namespace

PulseFit fit_pulses(const device::MotorParameters &file, std::span<const PulseLevel> levels) {
    PulseFit fit;
    for (std::size_t i = 0; i < kBrushCurves; ++i) {
        fit.curve[i] = {kMinBrush_A * std::pow(kMaxBrush_A / kMinBrush_A,
                                               static_cast<double>(i) / (kBrushCurves - 1)),
                        file.resistance_Ohm, 0.0, 0.0};
    }
    if (levels.empty()) {
        return fit;
    }
    std::array<std::array<double, 3>, kBrushCurves> value{}; // R, V_b, L of a curve
    std::array<std::array<double, 3>, kBrushCurves> variance{};
    double min_chi2 = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < kBrushCurves; ++i) {
        fit.curve[i] = solved(file, levels, fit.curve[i].brush_A, variance[i][0], variance[i][1]);
        const BrushCurve &curve = fit.curve[i];
        double weights = 0.0; // the lag's noise is that of the current
        double sum_H = 0.0;
        double squares_H2 = 0.0;
        for (const PulseLevel &level : levels) {
            const double weight = level.current_A * level.current_A;
            const double L_H = inductance_H(curve, level);
            weights += weight;
            sum_H += weight * L_H;
            squares_H2 += weight * L_H * L_H;
        }
        const double mean_H = sum_H / weights;
        value[i] = {curve.resistance_Ohm, curve.voltage_V, mean_H};
        variance[i][2] = std::max(0.0, squares_H2 / weights - mean_H * mean_H) /
                         std::max(1.0, static_cast<double>(levels.size()) - 1.0);
        min_chi2 = std::min(min_chi2, curve.chi2);
    }
    std::array<double, 3> mean{};
    std::array<double, 3> squares{};
    double sum = 0.0;
    for (std::size_t i = 0; i < kBrushCurves; ++i) {
        fit.curve[i].chi2 -= min_chi2;
        const double weight = std::exp(-0.5 * fit.curve[i].chi2);
        sum += weight;
        for (std::size_t k = 0; k < 3; ++k) {
            mean[k] += weight * value[i][k];
            squares[k] += weight * (variance[i][k] + value[i][k] * value[i][k]);
        }
    }
    const auto deviation = [&](std::size_t k) {
        return std::sqrt(std::max(0.0, squares[k] / sum - mean[k] * mean[k] / (sum * sum)));
    };
    fit.resistance_Ohm = mean[0] / sum;
    fit.brush_V = mean[1] / sum;
    fit.inductance_H = mean[2] / sum;
    fit.resistance_deviation_Ohm = deviation(0);
    fit.brush_deviation_V = deviation(1);
    fit.inductance_deviation_H = deviation(2);
    return fit;
}

} // namespace springdrive::commissioning
