#include "engine/commissioning/brush_fit.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace springdrive::commissioning {

namespace {

/// Duration of a window: rounding of angles is that of its ends, 0.4 mV at 1024 lines.
constexpr double kFitWindow_s = 0.04;
/// From so many windows come R and o, and with less than as many again nothing is known.
constexpr int kMinWindows = 100;
/// An offset of the curves, by less than this, is not felt [A]: V_b is that of both directions.
constexpr double kOffset_A = 0.3e-3;
/// Windows with less current teach nothing: of tanh(i/i_b) there, noise makes another curve.
constexpr double kMinCurrent_A = 0.03;
/// What R_wh, with the same copper behind it, may be instead of the file's, of which R tells, and
/// the standard deviation of how much of the difference there is.
constexpr std::array<double, 3> kHeatWays{1.0, 0.5, 2.0};
constexpr double kHeatError = 0.5;
/// Values of i_b that are tried between two curves.
constexpr int kBetweenCurves = 8;
/// What brushes' film and ripples leave is shared by many windows, so that deviations are larger
/// than by independent ones: of drawn devices by this factor, r.m.s.
constexpr double kShared = 3.0;
/// A film that grows and wears moves i_b meanwhile; of drawn devices, V_b is off by this and this
/// share of it, r.m.s., however long it takes.
constexpr double kFilm_V = 2e-4;
constexpr double kFilmShare = 2e-3;
/// Of χ² with one degree of freedom.
constexpr double k95OfChi2 = 3.84;

device::WindingTemperature temperature(device::ThermalParameters thermal, double way,
                                       double period_s) {
    thermal.winding_housing_K_per_W *= way;
    thermal.winding_time_s *= way;
    return {thermal, device::kReferenceTemperature_C, period_s};
}

} // namespace

BrushFit::BrushFit(const device::DeviceDescription &device, std::size_t motor, double period_s)
    : motor_(device.motor[motor]), temperature_{temperature(motor_.thermal, kHeatWays[0], period_s),
                                                temperature(motor_.thermal, kHeatWays[1], period_s),
                                                temperature(motor_.thermal, kHeatWays[2],
                                                            period_s)},
      count_variance_V2s2_(std::pow(motor_.torque_constant_Nm_per_A * device.rad_per_count(), 2) /
                           6.0),
      resistance_Ohm_(motor_.resistance_Ohm) {
    for (Eigen::Index i = 0; i < kCurves; ++i) {
        brush_A_[i] = kMinBrush_A *
                      std::pow(kMaxBrush_A / kMinBrush_A, static_cast<double>(i) / (kCurves - 1));
    }
    products_.setZero();
}

void BrushFit::skip(double current_A) {
    warm(std::isfinite(current_A) ? current_A : 0.0);
    window_.setZero();
    window_s_ = 0.0;
}

void BrushFit::warm(double current_A) {
    for (device::WindingTemperature &way : temperature_) {
        way.update(resistance_Ohm_ * current_A * current_A);
    }
}

void BrushFit::update(const control::DrivenInterval &interval) {
    const double T = interval.duration_s;
    const double mean_A = control::mean_current_A(interval, resistance_Ohm_ - interval.R_hat_Ohm,
                                                  motor_.inductance_H);
    const double current_A = mean_A - offset_A_;
    const auto winding_C = [this](std::size_t way) { return temperature_[way].winding_C(); };
    const double warmth =
        1.0 + motor_.resistance_rise_per_K * (winding_C(0) - device::kReferenceTemperature_C);
    const double phase_rad =
        0.5 * motor_.commutator_segments * (interval.before_rad + interval.after_rad);
    Row row;
    row << interval.e_W_V * T + interval.R_hat_Ohm * mean_A * T -
               motor_.inductance_H * (interval.after_A - interval.before_A),
        warmth * current_A * T *
            Eigen::Matrix<double, 5, 1>(1.0, std::cos(phase_rad), std::sin(phase_rad),
                                        std::cos(2.0 * phase_rad), std::sin(2.0 * phase_rad)),
        -T, interval.after_rad - interval.before_rad,
        motor_.resistance_rise_per_K * current_A * T *
            Eigen::Vector2d(winding_C(1) - winding_C(0), winding_C(2) - winding_C(0)),
        T * (current_A / brush_A_).tanh().matrix();
    window_ += row;
    const double least_A = std::abs(current_A);
    min_window_A_ = window_s_ > 0.0 ? std::min(min_window_A_, least_A) : least_A;
    window_s_ += T;
    warm(mean_A);
    if (window_s_ >= kFitWindow_s) {
        take_window();
    }
}

void BrushFit::take_window() {
    if (min_window_A_ > kMinCurrent_A) {
        products_ += window_ * window_.transpose();
        ++windows_;
    }
    window_.setZero();
    window_s_ = 0.0;
    if (windows_ == kMinWindows && !has_offset_) {
        const Solution found = solve();
        resistance_Ohm_ = found.estimate.resistance.resistance_Ohm;
        has_offset_ = std::abs(found.offset_A) < kOffset_A;
        if (!has_offset_) { // curves of another o
            offset_A_ += found.offset_A;
            products_.setZero();
            windows_ = 0;
        }
    }
}

BrushEstimate BrushFit::estimate() const {
    return has_offset_ ? solve().estimate : Solution{}.estimate;
}

BrushFit::Solution BrushFit::solve() const {
    constexpr int kFree = kCommon + 1; // R is the first of them, and V_b the last
    constexpr int kOffset = 5;
    constexpr int kHeat = 7;
    using Vector = Eigen::Matrix<double, kFree, 1>;
    using Matrix = Eigen::Matrix<double, kFree, kFree>;
    struct Tried {
        double brush_A = 0.0;
        double left_V2s2 = 0.0; ///< S
        double offset_A = 0.0;
        Vector free;
        Vector variance; ///< of each, as a share of what is left of a window
    };
    std::array<Tried, (kCurves - 1) * kBetweenCurves + 1> tried;
    for (std::size_t i = 0; i < tried.size(); ++i) {
        const Eigen::Index curve =
            std::min(static_cast<Eigen::Index>(i) / kBetweenCurves, Eigen::Index{kCurves - 2});
        const double share = static_cast<double>(i) / kBetweenCurves - static_cast<double>(curve);
        const Eigen::Vector2d weights(1.0 - share, share);
        Matrix products; // of the unknowns' columns
        products.topLeftCorner<kCommon, kCommon>() = products_.block<kCommon, kCommon>(1, 1);
        const Vector by_curve =
            products_.block<kFree, 2>(0, kFree + curve) * weights; // with the voltage's, too
        products.col(kCommon) << by_curve.tail<kCommon>(),
            weights.dot(products_.block<2, 2>(kFree + curve, kFree + curve) * weights);
        products.row(kCommon) = products.col(kCommon).transpose();
        products.diagonal().segment<2>(kHeat).array() +=
            count_variance_V2s2_ / std::pow(kHeatError * motor_.resistance_Ohm, 2);
        Vector against;
        against << products_.col(0).segment<kCommon>(1), by_curve[0];
        const Vector scale = products.diagonal().cwiseSqrt().cwiseInverse();
        if (windows_ < kMinWindows || !scale.allFinite()) {
            return {};
        }
        const Matrix inverse = scale.asDiagonal() *
                               Matrix(scale.asDiagonal() * products * scale.asDiagonal())
                                   .ldlt()
                                   .solve(Matrix::Identity()) *
                               scale.asDiagonal();
        tried[i].brush_A = weights.dot(brush_A_.matrix().segment<2>(curve));
        tried[i].free = inverse * against;
        tried[i].left_V2s2 = products_(0, 0) - against.dot(tried[i].free);
        tried[i].variance = inverse.diagonal();
        // An offset by which the curves are off, too: of tanh(i/i_b), in the mean, as of R i.
        const double slope = 1.0 - products(kCommon, kCommon) / products(kOffset, kOffset);
        tried[i].offset_A = tried[i].free[kOffset] /
                            (tried[i].free[0] + tried[i].free[kCommon] * slope / tried[i].brush_A);
    }
    const double min_V2s2 = std::ranges::min_element(tried, {}, &Tried::left_V2s2)->left_V2s2;
    const double window_V2s2 =
        kShared * kShared * min_V2s2 / static_cast<double>(windows_ - kFree - 1);
    Solution found;
    BrushEstimate &estimate = found.estimate;
    double sum = 0.0;
    Vector mean = Vector::Zero();
    Vector squares = Vector::Zero();
    std::swap(estimate.min_A, estimate.max_A);
    for (const Tried &one : tried) {
        const double chi2 = (one.left_V2s2 - min_V2s2) / window_V2s2;
        const double weight = std::exp(-0.5 * chi2);
        sum += weight;
        mean += weight * one.free;
        found.offset_A += weight * one.offset_A;
        squares += weight * (one.free.cwiseAbs2() + window_V2s2 * one.variance);
        if (chi2 <= k95OfChi2) {
            estimate.min_A = std::min(estimate.min_A, one.brush_A);
            estimate.max_A = std::max(estimate.max_A, one.brush_A);
        }
    }
    mean /= sum;
    found.offset_A /= sum;
    const Vector deviation = (squares / sum - mean.cwiseAbs2()).cwiseMax(0.0).cwiseSqrt();
    estimate.resistance = {mean[0], deviation[0]};
    estimate.voltage_V = mean[kCommon];
    estimate.deviation_V = std::hypot(deviation[kCommon], kFilm_V, kFilmShare * mean[kCommon]);
    return found;
}

} // namespace springdrive::commissioning
