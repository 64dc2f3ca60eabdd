// The voltage of brushes and bridge, V_b tanh(i/i_b), apart from R, by what a motor took at all of
// its levels of current: a batch estimate, beside the observer's, which need not know i_b.
//
// Over a window, as in winding_observer.h,
//
//   ∫e_W dt + R̂ ∫i dt − L Δi = R(T, θ) ∫(i − o) dt + V_b ∫tanh((i − o)/i_b) dt + k_T Δθ
//
// Between two levels far above i_b, in one direction of current, R is ΔV/ΔI and V_b = V − R I; the
// way between them tells i_b, but for windows near zero, where noise makes another curve. With i_b
// given, R, its ripple, R o, k_T and V_b enter linearly, and one matrix of products serves all i_b:
// tanh(i/i_b) is summed up for kCurves of them, and taken as linear in between, to 0.1 % of V_b. So
// is what R would be with half and twice the way of heat from winding to housing. The deviations
// follow from what is left, S, with which each i_b is weighed:
//
//   E[x] = Σ w x,  var x = Σ w (var x|i_b + x²) − E[x]²,  w ∝ exp(−S(i_b)/(2 S_min/(n − p)))
//
// An offset o of some mA also bends the curves: it is taken off, and the sums begin anew.
#pragma once

#include "device/core/device_description.h"
#include "device/core/motor/winding_heat.h"
#include "engine/control/winding_observer.h"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <limits>

namespace springdrive::commissioning {

/// Between these is i_b, of brushes and bridges [A].
inline constexpr double kMinBrush_A = 0.01;
inline constexpr double kMaxBrush_A = 0.2;

/// Deviations are standard deviations, infinite where too little is known; of R as a calibration
/// has it, at 25 °C in air of 25 °C.
struct BrushEstimate {
    control::ResistanceEstimate resistance{0.0, std::numeric_limits<double>::infinity()};
    double voltage_V = 0.0; ///< V_b
    double deviation_V = std::numeric_limits<double>::infinity();
    double min_A = kMinBrush_A; ///< i_b, between this
    double max_A = kMaxBrush_A; ///< and this, 95 of 100
};

/// Of one motor.
class BrushFit {
public:
    BrushFit(const device::DeviceDescription &device, std::size_t motor, double period_s);

    void update(const control::DrivenInterval &interval);

    /// An interval about which only the current is known.
    void skip(double current_A);

    [[nodiscard]] BrushEstimate estimate() const;

private:
    static constexpr int kCurves = 18;
    static constexpr int kCommon = 9; ///< R, its ripple, R o, k_T, R by other ways of heat
    /// The voltage, what is in common, and a curve for each i_b.
    static constexpr int kColumns = 1 + kCommon + kCurves;
    using Row = Eigen::Matrix<double, kColumns, 1>;

    struct Solution {
        BrushEstimate estimate;
        double offset_A = 0.0; ///< beyond that of the curves
    };

    void warm(double current_A);
    void take_window();
    [[nodiscard]] Solution solve() const;

    device::MotorParameters motor_;
    /// As the file has it, and with a half and twice the way of heat from winding to housing.
    std::array<device::WindingTemperature, 3> temperature_;
    double count_variance_V2s2_; ///< of a window, by the rounding of its angles
    double resistance_Ohm_;
    double offset_A_ = 0.0;
    bool has_offset_ = false;
    Eigen::Array<double, kCurves, 1> brush_A_; ///< i_b of the curves
    Row window_{Row::Zero()};
    double window_s_ = 0.0;
    double min_window_A_ = 0.0;                          ///< of |i − o|
    Eigen::Matrix<double, kColumns, kColumns> products_; ///< of all windows
    int windows_ = 0;
};

} // namespace springdrive::commissioning
