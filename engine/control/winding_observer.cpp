#include "engine/control/winding_observer.h"

#include "device/core/motor/winding_heat.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace springdrive::control {

namespace {

// The states, in this order; cosine and sine of each harmonic follow each other.
constexpr Eigen::Index kResistance = 0;      ///< mean over the angles, at 25 °C [Ω]
constexpr Eigen::Index kRipple = 1;          ///< six amplitudes [Ω]
constexpr Eigen::Index kBrushes = 7;         ///< the voltage's parts by i_b [V]
constexpr Eigen::Index kOffset = 11;         ///< of the current [A]
constexpr Eigen::Index kTorqueConstant = 12; ///< [N·m/A]
constexpr Eigen::Index kRounding = 13;       ///< of the last angle [rad]

/// The harmonics of s that the ripple has.
constexpr std::array kHarmonics{1, 2, 4};

/// i_b is between the first and the last, evenly in its logarithm.
constexpr std::array kBrushCurrents_A{0.01, 0.02714, 0.07368, 0.2};
constexpr auto kBrushCount = static_cast<Eigen::Index>(kBrushCurrents_A.size());

/// By how much the file's R may be wrong, whatever tolerance it states: it may be another motor's.
/// Only a file without any tolerance is of a device that is exactly known.
constexpr double kFileError = 0.2;

/// How far the sensor's offset may drift [A²/s]: 0.01 mA in a second.
constexpr double kOffsetDrift_A2_per_s = 1e-10;

/// An estimate is settled once its standard deviation has been below this share of R for so long.
constexpr double kSettled = 0.02;
constexpr double kSettling_s = 0.5;

/// A window that surprises by more than this many standard deviations teaches nothing.
constexpr double kOutlier = 4.0;

/// The square of a ripple is at most so many times its variance: twice, and what harmonics of
/// another period add to it.
constexpr double kMaxRippleSquare = 4.0;

/// So many outliers, less a quarter of the other windows, and nothing is believed.
constexpr double kMaxDisbelief = 8.0;
constexpr double kBelief = 0.25;

/// R, V_b and offset are told apart where the current differs by this share from its mean over the
/// last kUsual_s.
constexpr double kVaried = 0.1;
constexpr double kUsual_s = 0.5;

/// So many outliers, and an estimate is not settled.
constexpr double kDoubt = 3.0;

/// What was measured is explained if it is off by no more than this variance, in expected ones.
constexpr double kExplained = 3.0;

/// For how long what is measured has to agree with an estimate that is settled until it is trusted
/// again; doubled by each further distrust.
constexpr double kRegain_s = 3.0;
constexpr int kMaxDoublings = 10;

/// Amplitudes of the harmonics as shares of the file's ripple, as assumed before they are observed.
/// An odd number of segments passes two brushes in turn: then all of the ripple has the period of
/// 2 s, with a harmonic of its own.
constexpr std::array kHarmonicShares{1.0, 1.0, 0.25};

/// k_T falls by at most this share as its magnets warm by 1 K, of ferrite, and its drift is that of
/// a random walk that reaches the same after kMagnetChange_K.
constexpr double kMagnetFall_per_K = 0.002;
constexpr double kMagnetChange_K = 10.0;

/// Amplitude of the ripple of k_T over the commutator's angle, as a share.
constexpr double kTorqueRipple = 0.02;

/// By how many periods e_W may act earlier or later than assumed.
constexpr double kDelayError = 0.3;

/// How far each part of the brushes' voltage may drift [V²/s]: 0.1 mV in a second.
constexpr double kBrushDrift_V2_per_s = 1e-8;

/// A film between brush and commutator changes i_b within seconds: variance by which parts pass
/// into each other in a second, as a share of V_b².
constexpr double kFilmDrift_per_s = 0.01;

/// Variance of the parts that leaves their sum as it is, as a share of E[V_b²]. Without it, all of
/// the largest V_b at one end of i_b would be five standard deviations off; with it, it is 2.2.
constexpr double kPartsSpread = 0.42;

/// By which share of V_b a sum of parts may differ from V_b tanh(i/i_b) where |i| is below i_b. It
/// is a few per cent, but of one sign: at the same current it is the same in each window.
constexpr double kBrushMisfit = 0.2;

/// Near the supply an amplifier may be at its limit.
constexpr double kWithinSupply = 0.98;

/// How far R may drift while its temperature is constant [Ω²/s]: 0.03 mΩ in a second.
constexpr double kDrift_Ohm2_per_s = 1e-9;

/// By which share the thermal network may be wrong about a change of R, when R has changed by
/// kWarmthChange: air 10 K warmer or colder makes 4 %.
constexpr double kNetworkError = 0.05;
constexpr double kWarmthChange = 0.1;

/// Intervals are added up to windows of this [s]. A mean current from those at an interval's ends
/// is wrong by what the speed changes in between, which goes with the current itself; over a window
/// only its ends count.
constexpr double kWindow_s = 0.032;

/// What the speed at a window's ends may cost [V·s], and of what an acceleration costs, the share
/// that is left.
constexpr double kMeanCurrent_Vs = 1e-6;
constexpr double kAcceleration = 0.2;

/// By which the air may be warmer or colder than its middle, 25 °C [K].
constexpr double kAir_K = 0.5 * (device::kWarmestAir_C - device::kColdestAir_C);

/// Variance of what is uniform within ± `half_width`.
[[nodiscard]] constexpr double uniform_variance(double half_width) {
    return half_width * half_width / 3.0;
}

/// The mean current as a weighted mean of those at the ends, for a constant net voltage: the weight
/// of the first one. z = dR T/L.
[[nodiscard]] double weight_of_first(double z) noexcept {
    if (std::abs(z) < 1e-3) {
        return 0.5 - z / 12.0; // to 1e-12
    }
    return 1.0 / z - 1.0 / std::expm1(z);
}

/// What a step of the net voltage adds to that mean [A], after a share `at` of the interval.
/// @param step_A  that the step would change the current by in the interval without a resistance
[[nodiscard]] double mean_of_step_A(double z, double step_A, double at) noexcept {
    const double rest = 1.0 - at;
    if (std::abs(z) < 1e-3) {
        return -0.5 * step_A * at * rest;
    }
    const double reached = -std::expm1(-z * rest); // of the step's final current
    return step_A / z * (rest - reached / z - (1.0 - weight_of_first(z)) * reached);
}

/// How far the current has come from the first to the last one after a share x of the interval, for
/// a constant net voltage, as a share.
[[nodiscard]] double way_after(double z, double x) noexcept {
    if (std::abs(z) < 1e-3) {
        return x + 0.5 * z * x * (1.0 - x); // to 1e-6
    }
    return std::expm1(-z * x) / std::expm1(-z);
}

/// Mean of tanh, and of its derivative, on a straight way between two arguments.
struct MeanTanh {
    double value = 0.0;
    double slope = 0.0;
};
[[nodiscard]] MeanTanh mean_tanh(double from, double to) noexcept {
    const auto ln_cosh = [](double x) {
        return std::abs(x) + std::log1p(std::exp(-2.0 * std::abs(x))); // less ln 2
    };
    const double way = to - from;
    if (std::abs(way) < 1e-3) {
        const double middle = std::tanh(0.5 * (from + to)); // to 1e-7
        return {middle, 1.0 - middle * middle};
    }
    return {(ln_cosh(to) - ln_cosh(from)) / way, (std::tanh(to) - std::tanh(from)) / way};
}

/// The mean square of a current between two, for a constant net voltage: what warms.
[[nodiscard]] double mean_square_A2(double z, double from_A, double to_A) noexcept {
    const double q = -std::expm1(-z);
    const double way = 1.0 - weight_of_first(z); // its mean, and that of its square
    const double way2 = std::abs(z) < 1e-3 ? 1.0 / 3.0 + z / 12.0 // to 1e-6
                                           : (1.0 - q / z * (1.0 + 0.5 * q)) / (q * q);
    const double change_A = to_A - from_A;
    return from_A * from_A + 2.0 * from_A * change_A * way + change_A * change_A * way2;
}

} // namespace

/// The current within an interval: to that at the step of e_W, and from there.
struct WindingObserver::Course {
    double before_A;
    double at_step_A;
    double after_A;
    double z;
    double step_at;

    Course(double z_of_interval, const DrivenInterval &interval, double step_A) noexcept
        : before_A(interval.before_A), at_step_A(interval.before_A), after_A(interval.after_A),
          z(z_of_interval), step_at(interval.step_at) {
        const double rest = 1.0 - step_at;
        const double by_step_A = step_A * (std::abs(z) < 1e-3 ? rest * (1.0 - 0.5 * z * rest)
                                                              : -std::expm1(-z * rest) / z);
        at_step_A += (after_A - before_A - by_step_A) * way_after(z, step_at);
    }

    /// Where the voltage changes its sign with every tick, the mean current is none, and there is
    /// heat.
    [[nodiscard]] double mean_square() const noexcept {
        const double rest = 1.0 - step_at;
        return step_at * mean_square_A2(z * step_at, before_A, at_step_A) +
               rest * mean_square_A2(z * rest, at_step_A, after_A);
    }
};

double mean_current_A(const DrivenInterval &interval, double dR_Ohm, double inductance_H) noexcept {
    const double z = dR_Ohm * interval.duration_s / inductance_H;
    const double first = weight_of_first(z);
    const double step_A = interval.e_W_step_V * interval.duration_s / inductance_H;
    return first * interval.before_A + (1.0 - first) * interval.after_A +
           mean_of_step_A(z, step_A, interval.step_at);
}

ObservedMotor known_at_start(const device::DeviceDescription &device, std::size_t motor) {
    constexpr double kAny_s = 1e-3;
    return WindingObserver(device, motor, kAny_s).motor(0.0);
}

double touch_left_s(const device::DeviceDescription &device, std::size_t motor,
                    const ObservedMotor &known, double dR_Ohm, double current_A) {
    if (!known.is_trusted) {
        return 0.0;
    }
    const double deviation_Ohm = held_up_dR_Ohm(known) / kHeldUpDeviations;
    const double enough_Ohm =
        device::residual_resistance_Ohm(device.motor[motor], dR_Ohm) / kHeldUpDeviations;
    if (deviation_Ohm <= enough_Ohm) {
        return 0.0;
    }
    const double count_V = device.motor[motor].torque_constant_Nm_per_A * device.rad_per_count() /
                           std::sqrt(6.0) / kWindow_s; // rounded at both ends
    // R apart from V_b shows only as far as |i| varies: taken as one that a hand does not hold
    // still.
    constexpr double kVariation = 0.3;
    const double used_A = (known.brush_deviation_V > 0.0 ? kVariation : 1.0) * std::abs(current_A);
    const double window_Ohm = count_V / used_A;
    return kWindow_s * window_Ohm * window_Ohm *
           (1.0 / (enough_Ohm * enough_Ohm) - 1.0 / (deviation_Ohm * deviation_Ohm));
}

WindingObserver::WindingObserver(const device::DeviceDescription &device, std::size_t motor,
                                 double period_s)
    : motor_(device.motor[motor]), sensing_(device.current_sensing),
      count_variance_rad2_(uniform_variance(0.5 * device.rad_per_count())),
      current_variance_A2_(sensing_.noise_A * sensing_.noise_A +
                           uniform_variance(0.5 * sensing_.resolution_A)),
      zero_by_eye_rad_(device.geometry.transmission_ratio[static_cast<Eigen::Index>(motor)] *
                       std::sqrt(uniform_variance(device::kZeroByEye_rad))),
      temperature_(motor_.thermal, device::kReferenceTemperature_C, period_s) {
    if (const std::optional<device::Calibration> &calibration = device.calibration) {
        calibration_ = calibration->motor[motor];
        air_variance_K2_ = uniform_variance(calibration->air_error_K) + uniform_variance(kAir_K);
        has_zero_of_calibration_ = calibration->has_lasting_zero();
    }
    start_from_file();
    file_state_ = state_;
    file_covariance_ = covariance_;
    restart();
}

void WindingObserver::restart() noexcept {
    start_from_file();
    if (calibration_) {
        start_from_calibration();
    }
    begin_window();
    mean_before_A_ = 0.0;
    settled_windows_ = 0;
    disbelief_ = 0.0;
    other_ripple_Ohm2_ = calibration_ ? 0.0 : max_other_ripple_Ohm2();
    other_ripple_shown_ = 0;
    usual_A_ = 0.0;
    distrusts_ = 0;
    is_trusted_ = true;
}

void WindingObserver::start_from_file() noexcept {
    const double R_Ohm = motor_.resistance_Ohm;
    const double file_error =
        motor_.resistance_tolerance > 0.0 ? std::max(motor_.resistance_tolerance, kFileError) : 0.0;
    state_.setZero();
    state_[kResistance] = R_Ohm;
    state_[kTorqueConstant] = motor_.torque_constant_Nm_per_A;
    covariance_.setZero();
    covariance_(kResistance, kResistance) =
        R_Ohm * R_Ohm *
        (uniform_variance(file_error) + uniform_variance(sensing_.gain_tolerance) +
         uniform_variance(motor_.resistance_rise_per_K * kAir_K));
    const double ripple_Ohm = R_Ohm * motor_.commutation_ripple;
    for (Eigen::Index i = kRipple; i < kBrushes; ++i) {
        const double amplitude_Ohm =
            kHarmonicShares[static_cast<std::size_t>(i - kRipple) / 2] * ripple_Ohm;
        covariance_(i, i) = 0.5 * amplitude_Ohm * amplitude_Ohm;
    }
    const double max_V = is_exactly_known() ? 0.0 : motor_.max_brush_voltage_V;
    start_brushes(0.5 * max_V, uniform_variance(0.5 * max_V));
    covariance_(kOffset, kOffset) = uniform_variance(sensing_.max_offset_A);
    covariance_(kTorqueConstant, kTorqueConstant) =
        uniform_variance(motor_.torque_constant_tolerance * motor_.torque_constant_Nm_per_A) +
        uniform_variance(magnet_fall_per_K() * kAir_K * motor_.torque_constant_Nm_per_A);
    covariance_(kRounding, kRounding) = count_variance_rad2_;
}

/// With i_b anywhere between the first and the last of kBrushCurrents_A: V_b is shared by the two
/// next to it, linearly in its logarithm.
void WindingObserver::start_brushes(double mean_V, double variance_V2) noexcept {
    constexpr double kBetween = 1.0 / static_cast<double>(kBrushCount - 1);
    using Shares = Eigen::Matrix<double, kBrushCount, 1>;
    Shares mean = Shares::Constant(kBetween);
    mean[0] = mean[kBrushCount - 1] = 0.5 * kBetween;
    Eigen::Matrix<double, kBrushCount, kBrushCount> square; // E[share · share]
    square.setZero();
    for (Eigen::Index i = 0; i + 1 < kBrushCount; ++i) {
        square(i, i) += kBetween / 3.0;
        square(i + 1, i + 1) += kBetween / 3.0;
        square(i, i + 1) = square(i + 1, i) = kBetween / 6.0;
    }
    state_.segment<kBrushCount>(kBrushes) = mean_V * mean;
    covariance_.block<kBrushCount, kBrushCount>(kBrushes, kBrushes) =
        (mean_V * mean_V + variance_V2) * square - mean_V * mean_V * mean * mean.transpose();
    spread_brushes(kPartsSpread * (mean_V * mean_V + variance_V2));
}

void WindingObserver::start_from_calibration() noexcept {
    const auto square = [](double value) { return value * value; };
    state_[kResistance] = calibration_->resistance_Ohm;
    covariance_(kResistance, kResistance) =
        square(calibration_->resistance_deviation_Ohm) +
        square(calibration_->resistance_Ohm * motor_.resistance_rise_per_K) * air_variance_K2_;
    take_ripple(1, calibration_->ripple_cos_Ohm, calibration_->ripple_sin_Ohm,
                calibration_->ripple_deviation_Ohm);
    take_ripple(2, calibration_->ripple_cos_2_Ohm, calibration_->ripple_sin_2_Ohm,
                calibration_->ripple_2_deviation_Ohm);
    if (calibration_->brush_deviation_V > 0.0) {
        start_brushes(calibration_->brush_voltage_V, square(calibration_->brush_deviation_V));
    }
    state_[kTorqueConstant] = calibration_->torque_constant_Nm_per_A;
    covariance_(kTorqueConstant, kTorqueConstant) =
        square(calibration_->torque_constant_deviation_Nm_per_A) +
        uniform_variance(magnet_fall_per_K() * kAir_K * motor_.torque_constant_Nm_per_A);
    if (has_zero_of_calibration_) {
        state_[kOffset] = calibration_->offset_A;
        covariance_(kOffset, kOffset) = square(calibration_->offset_deviation_A);
    }
}

void WindingObserver::take_ripple(Eigen::Index harmonic, double cos_Ohm, double sin_Ohm,
                                  double deviation_Ohm) noexcept {
    const double phase_rad = static_cast<double>(harmonic) * motor_.commutator_segments *
                             (has_zero_of_calibration_ ? 0.0 : zero_by_eye_rad_);
    const double f = std::exp(-0.5 * phase_rad * phase_rad); // E[cos]
    const double cos2 = 0.5 * (1.0 + f * f * f * f);         // E[cos²]
    const double sin2 = 1.0 - cos2;
    const double a2 = cos_Ohm * cos_Ohm;
    const double b2 = sin_Ohm * sin_Ohm;
    const Eigen::Index i = kRipple + 2 * (harmonic - 1);
    state_[i] = f * cos_Ohm;
    state_[i + 1] = f * sin_Ohm;
    const double variance_Ohm2 = deviation_Ohm * deviation_Ohm;
    covariance_(i, i) = variance_Ohm2 + cos2 * a2 + sin2 * b2 - f * f * a2;
    covariance_(i + 1, i + 1) = variance_Ohm2 + cos2 * b2 + sin2 * a2 - f * f * b2;
    covariance_(i, i + 1) = (cos2 - sin2 - f * f) * cos_Ohm * sin_Ohm;
    covariance_(i + 1, i) = covariance_(i, i + 1);
}

/// Adds this variance to each of the parts, and none to their sum.
void WindingObserver::spread_brushes(double variance_V2) noexcept {
    auto parts = covariance_.block<kBrushCount, kBrushCount>(kBrushes, kBrushes);
    parts.diagonal().array() += variance_V2 * kBrushCount / (kBrushCount - 1);
    parts.array() -= variance_V2 / (kBrushCount - 1);
}

/// By which share k_T falls as its magnets warm by 1 K.
double WindingObserver::magnet_fall_per_K() const noexcept {
    return is_exactly_known() ? 0.0 : kMagnetFall_per_K;
}

/// E[V_b²].
double WindingObserver::mean_square_brush_V2() const noexcept {
    const double mean_V = brushes().dot(state_);
    return mean_V * mean_V + brushes().dot(covariance_ * brushes());
}

/// V_b: the sum of its parts.
WindingObserver::State WindingObserver::brushes() noexcept {
    State weights = State::Zero();
    weights.segment<kBrushCount>(kBrushes).setOnes();
    return weights;
}

/// R(T)/R at 25 °C.
double WindingObserver::warmth() const noexcept {
    return 1.0 + motor_.resistance_rise_per_K *
                     (temperature_.winding_C() - device::kReferenceTemperature_C);
}

WindingObserver::State WindingObserver::weights_of_resistance(double theta_rad) const noexcept {
    const double phase_rad = motor_.commutator_segments * theta_rad;
    State weights = State::Zero();
    weights[kResistance] = 1.0;
    for (std::size_t k = 0; k < kHarmonics.size(); ++k) {
        const auto i = kRipple + 2 * static_cast<Eigen::Index>(k);
        weights[i] = std::cos(kHarmonics[k] * phase_rad);
        weights[i + 1] = std::sin(kHarmonics[k] * phase_rad);
    }
    return warmth() * weights;
}

void WindingObserver::skip(double current_A, std::uint32_t periods) noexcept {
    constexpr std::uint32_t kMaxAtOnce = 100;
    const double heat_W = std::isfinite(current_A) ? std::max(0.0, warmth() * state_[kResistance]) *
                                                         current_A * current_A
                                                   : 0.0;
    for (std::uint32_t i = 0; i < std::min(periods, kMaxAtOnce); ++i) {
        temperature_.update(heat_W);
    }
    begin_window();
    mean_before_A_ = 0.0;
    forget_rounding();
}

void WindingObserver::update(const DrivenInterval &interval) noexcept {
    const double T = interval.duration_s;
    const State of_resistance =
        weights_of_resistance(0.5 * (interval.before_rad + interval.after_rad));
    const double R_Ohm = of_resistance.dot(state_);
    const double dR_Ohm = R_Ohm - interval.R_hat_Ohm;
    const double z = dR_Ohm * T / motor_.inductance_H;
    const double step_A = interval.e_W_step_V * T / motor_.inductance_H;
    const Course course(z, interval, step_A);
    if (!is_within_supply(interval, course)) {
        skip(interval.after_A);
        return;
    }
    period_s_ = T;
    const double mean_A = mean_current_A(interval, dR_Ohm, motor_.inductance_H);
    voltage_Vs_ += interval.e_W_V * T + interval.R_hat_Ohm * mean_A * T -
                   motor_.inductance_H * (interval.after_A - interval.before_A);
    weights_ += (mean_A - state_[kOffset]) * T * of_resistance;
    of_noise_ += T * of_resistance;
    const double slope_Ohm = R_Ohm + add_brushes(course, T);
    weights_[kOffset] -= slope_Ohm * T;
    const double net_Ohm = slope_Ohm - interval.R_hat_Ohm;
    const double charge_As2 = T * T * current_variance_A2_;
    charge_As2_ += charge_As2;
    bias_VAs2_ += net_Ohm * charge_As2;
    current_Vs2_ += net_Ohm * net_Ohm * charge_As2;
    const double rate_rad_per_s = (interval.after_rad - interval.before_rad) / T;
    if (window_s_ == 0.0) {
        first_rate_rad_per_s_ = rate_rad_per_s;
        first_e_W_V_ = interval.e_W_V;
        first_R_hat_Ohm_ = interval.R_hat_Ohm;
    }
    last_rate_rad_per_s_ = rate_rad_per_s;
    last_e_W_V_ = interval.e_W_V;
    last_R_hat_Ohm_ = interval.R_hat_Ohm;
    asymmetry_s_ += (0.5 - weight_of_first(z)) * T;
    turned_rad_ += interval.after_rad - interval.before_rad;
    window_s_ += T;
    temperature_.update(std::max(0.0, R_Ohm) * course.mean_square());
    if (window_s_ >= kWindow_s) {
        take_window();
    }
}

/// Whether R̂ i + e_W has not come near the supply, where the amplifier does not follow (6).
bool WindingObserver::is_within_supply(const DrivenInterval &interval,
                                       const Course &course) const noexcept {
    const double older_V = interval.e_W_V - (1.0 - interval.step_at) * interval.e_W_step_V;
    const double newer_V = older_V + interval.e_W_step_V;
    const double limit_V = kWithinSupply * motor_.supply_V;
    const auto is_within = [&](double e_W_V, double current_A) {
        return std::abs(e_W_V + interval.R_hat_Ohm * current_A) < limit_V;
    };
    return (interval.step_at == 0.0 || is_within(older_V, course.before_A)) &&
           is_within(older_V, course.at_step_A) && is_within(newer_V, course.at_step_A) &&
           is_within(newer_V, course.after_A);
}

/// Adds what brushes and bridge drop in an interval.
/// @return its slope over the current [Ω]
double WindingObserver::add_brushes(const Course &course, double duration_s) noexcept {
    if (is_exactly_known() || motor_.max_brush_voltage_V == 0.0) {
        return 0.0;
    }
    // Each half of each part of the course is taken for linear in time, so that a change of sign is
    // right: ∫tanh(x) dx = ln cosh x.
    const double at = course.step_at;
    const std::array<double, 5> shares{0.5 * at, 0.5 * at, 0.5 * (1.0 - at), 0.5 * (1.0 - at)};
    std::array<double, 5> current_A{course.before_A,
                                    course.before_A + (course.at_step_A - course.before_A) *
                                                          way_after(course.z * at, 0.5),
                                    course.at_step_A,
                                    course.at_step_A + (course.after_A - course.at_step_A) *
                                                           way_after(course.z * (1.0 - at), 0.5),
                                    course.after_A};
    double slope_Ohm = 0.0;
    double misfit = 0.0;
    for (Eigen::Index part = 0; part < kBrushCount; ++part) {
        const double i_b_A = kBrushCurrents_A[static_cast<std::size_t>(part)];
        double mean = 0.0; // of tanh(i/i_b)
        double mean_slope_per_A = 0.0;
        for (std::size_t piece = at > 0.0 ? 0 : 2; piece < 4; ++piece) {
            const double from = (current_A[piece] - state_[kOffset]) / i_b_A;
            const double to = (current_A[piece + 1] - state_[kOffset]) / i_b_A;
            const MeanTanh found = mean_tanh(from, to);
            mean += shares[piece] * found.value;
            mean_slope_per_A += shares[piece] * found.slope / i_b_A;
        }
        weights_[kBrushes + part] += duration_s * mean;
        of_noise_[kBrushes + part] += duration_s * mean_slope_per_A;
        slope_Ohm += state_[kBrushes + part] * mean_slope_per_A;
        misfit += 1.0 - mean * mean;
    }
    misfit_s_ += kBrushMisfit / static_cast<double>(kBrushCount) * misfit * duration_s;
    return slope_Ohm;
}

/// Ends the present window.
void WindingObserver::take_window() noexcept {
    const double k_T = state_[kTorqueConstant];
    State h = weights_; // derivatives of what was measured
    h[kTorqueConstant] = turned_rad_ + state_[kRounding];
    h[kRounding] = k_T;
    // The current's offset is in the weights of R, and rounding in that of k_T.
    const double expected_Vs =
        h.dot(state_) - h[kOffset] * state_[kOffset] - k_T * state_[kRounding];
    const double warmed = std::abs(warmth() - std::exchange(warmth_before_, warmth()));
    const double network_Ohm = kNetworkError * motor_.resistance_Ohm;
    covariance_(kResistance, kResistance) +=
        kDrift_Ohm2_per_s * window_s_ + network_Ohm * network_Ohm * kWarmthChange * warmed;
    covariance_(kOffset, kOffset) += kOffsetDrift_A2_per_s * window_s_;
    if (!is_exactly_known()) {
        const double fall = magnet_fall_per_K() * k_T;
        covariance_(kTorqueConstant, kTorqueConstant) +=
            fall * fall * kMagnetChange_K *
            std::abs(temperature_.housing_C() -
                     std::exchange(housing_before_C_, temperature_.housing_C()));
        covariance_.diagonal().segment<kBrushCount>(kBrushes).array() +=
            kBrushDrift_V2_per_s * window_s_;
        spread_brushes(kFilmDrift_per_s * window_s_ * mean_square_brush_V2());
        covariance_.diagonal().segment<kBrushes - kRipple>(kRipple).array() +=
            kDrift_Ohm2_per_s * window_s_;
    }
    const bool had_enough = had_current();
    mean_before_A_ = weights_[kResistance] / (warmth() * window_s_);
    const double beyond_usual_A = std::abs(mean_before_A_) - usual_A_;
    const Evidence evidence = !had_enough                                     ? Evidence::none
                              : std::abs(beyond_usual_A) > kVaried * usual_A_ ? Evidence::apart
                                                                              : Evidence::of_sum;
    usual_A_ += window_s_ / kUsual_s * beyond_usual_A;
    // e_W that acts at another time than assumed: of all steps together, the change over the
    // window.
    const double stepped_V =
        last_e_W_V_ - first_e_W_V_ + (last_R_hat_Ohm_ - first_R_hat_Ohm_) * mean_before_A_;
    const double delayed_Vs2 =
        is_exactly_known() ? 0.0
                           : uniform_variance(kDelayError * period_s_) * stepped_V * stepped_V;
    // ∫k_T(θ) dθ: the ripple's ends.
    const double segments = std::max(1, motor_.commutator_segments);
    const double torque_ripple_Vs = is_exactly_known() ? 0.0 : k_T * kTorqueRipple / segments;
    const double swept = std::min(std::abs(segments * turned_rad_), std::numbers::pi / 2.0);
    const double torque_ripple_Vs2 = torque_ripple_Vs * torque_ripple_Vs * (1.0 - std::cos(swept));
    // Within an interval the speed changes, and the back-EMF's part of the current with it: of a
    // constant acceleration, dR times what the mean current differs by is this. It goes with the
    // current, so that it would be taken for R. Its rates are known to a count in an interval.
    const double lag_Vs2_per_rad = k_T * asymmetry_s_ / window_s_ * period_s_;
    const double accelerated_Vs = lag_Vs2_per_rad * (last_rate_rad_per_s_ - first_rate_rad_per_s_);
    const double rates_Vs = 2.0 * lag_Vs2_per_rad * std::sqrt(count_variance_rad2_) / period_s_;
    const double left_Vs = kAcceleration * accelerated_Vs;
    const double ends_Vs2 = 2.0 * motor_.inductance_H * motor_.inductance_H * current_variance_A2_ +
                            kMeanCurrent_Vs * kMeanCurrent_Vs + rates_Vs * rates_Vs +
                            left_Vs * left_Vs;
    const double surprise_Vs = voltage_Vs_ - expected_Vs - accelerated_Vs;
    // A product of two unknowns, R and the offset, which h leaves out.
    const State of_current = of_noise_ / window_s_;
    const State spread = covariance_ * of_current;
    const double product_Vs2 = window_s_ * window_s_ *
                               (of_current.dot(spread) * covariance_(kOffset, kOffset) +
                                spread[kOffset] * spread[kOffset]);
    const Noise noise{ends_Vs2 + current_Vs2_ + product_Vs2 + delayed_Vs2 + torque_ripple_Vs2 +
                          misfit_s_ * misfit_s_ * mean_square_brush_V2(),
                      charge_As2_,
                      bias_VAs2_,
                      weights_[kResistance] * weights_[kResistance],
                      swept / (std::numbers::pi / 2.0),
                      of_current};
    begin_window();
    learn(h, surprise_Vs, noise, evidence);
}

/// Whether the mean current is far above noise and what is not known of its offset. If it is not, a
/// product of two unknowns is no evidence about R: a linearised filter would take it for some. That
/// of the window before decides, or windows would be chosen by their own noise.
bool WindingObserver::had_current() const noexcept {
    constexpr double kDeviations = 10.0;
    const double variance_A2 =
        current_variance_A2_ * period_s_ / kWindow_s + covariance_(kOffset, kOffset);
    return mean_before_A_ * mean_before_A_ > kDeviations * kDeviations * variance_A2;
}

void WindingObserver::begin_window() noexcept {
    voltage_Vs_ = current_Vs2_ = charge_As2_ = bias_VAs2_ = misfit_s_ = asymmetry_s_ = turned_rad_ =
        window_s_ = 0.0;
    weights_.setZero();
    of_noise_.setZero();
}

/// The Kalman filter's step.
/// What is no evidence of a state leaves it as it is, and what is not known of it is considered in
/// what is learned of the others (Schmidt).
/// @param h  derivatives of what was measured
void WindingObserver::learn(const State &h, double surprise_Vs, const Noise &noise,
                            Evidence evidence) noexcept {
    const double k_T = h[kRounding];
    const State gain_numerator = covariance_ * h;
    const double rounding_Vs2 = k_T * k_T * count_variance_rad2_;
    // Variance without what is not known of R and V_b, but of both angles.
    const double rest_Vs2 = noise.voltage_Vs2 + rounding_Vs2 +
                            k_T * k_T * covariance_(kRounding, kRounding) +
                            other_ripple_Ohm2_ * noise.ripple_As2;
    const double modelled_Vs2 = h.dot(gain_numerator) + rounding_Vs2 + noise.voltage_Vs2;
    const double variance_Vs2 = modelled_Vs2 + other_ripple_Ohm2_ * noise.ripple_As2;
    if (evidence != Evidence::none) {
        note_other_ripple(surprise_Vs * surprise_Vs - kExplained * modelled_Vs2,
                          1.0 - modelled_Vs2 / variance_Vs2, noise);
    }
    const bool is_outlier =
        !(surprise_Vs * surprise_Vs < kOutlier * kOutlier * modelled_Vs2 +
                                          kMaxRippleSquare * other_ripple_Ohm2_ * noise.ripple_As2);
    note_surprise(is_outlier);
    if (is_outlier) {
        forget_rounding();
        return;
    }
    State gain = gain_numerator / variance_Vs2;
    if (evidence == Evidence::none) {
        gain.segment<kOffset - kResistance>(kResistance).setZero();
    } else if (evidence == Evidence::of_sum) {
        // At the same |i| as before, only noise and errors of the model, which go with the current,
        // would tell them apart.
        gain.segment<kTorqueConstant - kBrushes>(kBrushes).setZero();
    }
    state_ += surprise_Vs * gain;
    const Covariance taken = gain * gain_numerator.transpose();
    covariance_ += variance_Vs2 * gain * gain.transpose() - taken - taken.transpose();

    // The new angle's rounding takes the old one's place. It entered with the factor −k_T.
    const double rounding_gain = -k_T * count_variance_rad2_ / variance_Vs2;
    state_[kRounding] = rounding_gain * surprise_Vs;
    covariance_.row(kRounding) = -rounding_gain * gain_numerator.transpose();
    covariance_.col(kRounding) = covariance_.row(kRounding).transpose();
    covariance_(kRounding, kRounding) =
        count_variance_rad2_ - rounding_gain * rounding_gain * variance_Vs2;
    if (evidence != Evidence::none) {
        if (evidence == Evidence::apart) {
            compensate(noise, rest_Vs2);
        }
        const double settled_Ohm = kSettled * state_[kResistance];
        settled_windows_ +=
            covariance_(kResistance, kResistance) < settled_Ohm * settled_Ohm ? 1 : 0;
        const double regain_s = kRegain_s * std::exp2(std::clamp(distrusts_ - 1, 0, kMaxDoublings));
        is_trusted_ = is_trusted_ || settled_windows_ * kWindow_s >= regain_s;
    }
}

/// The most that `note_other_ripple` finds: the file's ripple.
double WindingObserver::max_other_ripple_Ohm2() const noexcept {
    const double amplitude_Ohm = motor_.commutation_ripple * motor_.resistance_Ohm;
    return is_exactly_known() ? 0.0 : 0.5 * amplitude_Ohm * amplitude_Ohm;
}

/// What the harmonics do not explain while the rotor turns may be ripple of another period, as of
/// another number of segments: noise then. It is assumed until windows that would show it do not,
/// and again as soon as one does; the more often, the longer, as a rotor that swings shows it only
/// in places.
/// @param unexplained_Vs2  what surprised beyond what was expected without it
/// @param share            of what was expected that is due to it
void WindingObserver::note_other_ripple(double unexplained_Vs2, double share,
                                        const Noise &noise) noexcept {
    constexpr double kForgotten = 0.1; // share, each window in which the rotor turns
    constexpr double kShown = 0.02;    // of the most: far above noise
    constexpr int kMaxShown = 40;
    const double max_Ohm2 = max_other_ripple_Ohm2();
    const double seen_Ohm2 = std::max(0.0, unexplained_Vs2) / std::max(noise.ripple_As2, 1e-12);
    if (seen_Ohm2 > kMaxRippleSquare * max_Ohm2) {
        return; // more than a ripple
    }
    const bool is_more = seen_Ohm2 > other_ripple_Ohm2_;
    if (is_more && seen_Ohm2 > kShown * max_Ohm2 && noise.turning > 0.0) {
        other_ripple_shown_ = std::min(other_ripple_shown_ + 1, kMaxShown);
    }
    const double followed =
        noise.turning * (is_more ? 1.0 : kForgotten * share / (1.0 + other_ripple_shown_));
    other_ripple_Ohm2_ =
        std::min(max_Ohm2, other_ripple_Ohm2_ + followed * (seen_Ohm2 - other_ripple_Ohm2_));
}

/// The current's noise is in h as well: it looks like a current that changes, whose voltage changes
/// by R̂ times it, and so, in time, like an R of R̂. What that adds to the information about R,
/// and to R, is taken off again.
void WindingObserver::compensate(const Noise &noise, double variance_Vs2) noexcept {
    const State spread = covariance_ * noise.of_current;
    const double information = noise.charge_As2 / variance_Vs2;
    const double left = 1.0 - information * noise.of_current.dot(spread);
    if (left > 0.5) {
        covariance_ += (information / left) * spread * spread.transpose();
        state_ += (noise.bias_VAs2 / (variance_Vs2 * left)) * spread;
    }
}

/// The last angle is another, whose rounding is not known.
void WindingObserver::forget_rounding() noexcept {
    state_[kRounding] = 0.0;
    covariance_.row(kRounding).setZero();
    covariance_.col(kRounding).setZero();
    covariance_(kRounding, kRounding) = count_variance_rad2_;
}

void WindingObserver::note_surprise(bool is_outlier) noexcept {
    disbelief_ = std::max(0.0, disbelief_ + (is_outlier ? 1.0 : -kBelief));
    settled_windows_ = disbelief_ >= kDoubt ? 0 : settled_windows_;
    if (disbelief_ >= kMaxDisbelief) {
        distrust();
    }
}

bool WindingObserver::is_settled() const noexcept {
    return is_trusted_ && settled_windows_ * kWindow_s >= kSettling_s;
}

void WindingObserver::distrust() noexcept {
    const int distrusts = distrusts_ + (is_trusted_ ? 1 : 0);
    restart();
    start_from_file(); // it may be the calibration that is wrong
    other_ripple_Ohm2_ = max_other_ripple_Ohm2();
    distrusts_ = distrusts;
    is_trusted_ = false;
}

ResistanceEstimate WindingObserver::estimate(const State &weights) const noexcept {
    const Covariance &covariance = is_trusted_ ? covariance_ : file_covariance_;
    return {weights.dot(published()), std::sqrt(std::max(0.0, weights.dot(covariance * weights)))};
}

device::MotorCalibration WindingObserver::learned() const noexcept {
    const State &state = published();
    const auto deviation = [this](Eigen::Index of) {
        return estimate(State::Unit(of)).deviation_Ohm;
    };
    device::MotorCalibration learned;
    learned.resistance_Ohm = state[kResistance];
    learned.resistance_deviation_Ohm = deviation(kResistance);
    learned.ripple_cos_Ohm = state[kRipple];
    learned.ripple_sin_Ohm = state[kRipple + 1];
    learned.ripple_deviation_Ohm = std::max(deviation(kRipple), deviation(kRipple + 1));
    learned.ripple_cos_2_Ohm = state[kRipple + 2];
    learned.ripple_sin_2_Ohm = state[kRipple + 3];
    learned.ripple_2_deviation_Ohm = std::max(deviation(kRipple + 2), deviation(kRipple + 3));
    learned.torque_constant_Nm_per_A = state[kTorqueConstant];
    learned.torque_constant_deviation_Nm_per_A = deviation(kTorqueConstant);
    learned.offset_A = state[kOffset];
    learned.offset_deviation_A = deviation(kOffset);
    const ResistanceEstimate brush = estimate(brushes());
    learned.brush_voltage_V = std::clamp(brush.resistance_Ohm, 0.0, motor_.max_brush_voltage_V);
    learned.brush_deviation_V = brush.deviation_Ohm;
    return learned;
}

ObservedMotor WindingObserver::motor(double theta_rad) const noexcept {
    const double k_T = motor_.torque_constant_Nm_per_A;
    // In warm magnets it is less than what the tolerance allows, and in cold ones more.
    const double warm_K = temperature_.housing_C() - device::kReferenceTemperature_C;
    const double fall = magnet_fall_per_K();
    const double tolerance = motor_.torque_constant_tolerance;
    const State &state = published();
    const ResistanceEstimate brush = estimate(brushes());
    return {at(theta_rad),
            mean(),
            std::clamp(state[kTorqueConstant],
                       k_T * (1.0 - tolerance - fall * (std::max(0.0, warm_K) + kAir_K)),
                       k_T * (1.0 + tolerance + fall * kAir_K)),
            std::clamp(state[kOffset], -sensing_.max_offset_A, sensing_.max_offset_A),
            true,
            is_trusted_,
            std::clamp(brush.resistance_Ohm, 0.0, motor_.max_brush_voltage_V),
            brush.deviation_Ohm};
}

ResistanceEstimate WindingObserver::at(double theta_rad) const noexcept {
    ResistanceEstimate here = estimate(weights_of_resistance(theta_rad));
    here.deviation_Ohm = std::sqrt(here.deviation_Ohm * here.deviation_Ohm +
                                   (is_trusted_ ? other_ripple_Ohm2_ : 0.0));
    return here;
}

ResistanceEstimate WindingObserver::mean() const noexcept {
    State weights = State::Zero();
    weights[kResistance] = warmth();
    return estimate(weights);
}

ResistanceEstimate WindingObserver::unheated() const noexcept {
    State weights = State::Zero();
    weights[kResistance] = 1.0;
    return estimate(weights);
}

} // namespace springdrive::control
