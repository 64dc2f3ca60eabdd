#include "engine/commissioning/sweep.h"

#include "base/assertions.h"
#include "device/core/split_delay.h"
#include "engine/control/velocity_filter.h"

#include <Eigen/LU>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace springdrive::commissioning {

void SweepBlock::take(const BlockSample &sample) noexcept {
    const double phase = omega_rad_per_s_ * sample.time_s;
    const double dither = dither_rad_per_s_ * sample.time_s;
    const bool has_dither = dither_rad_per_s_ > 0.0;
    Eigen::Matrix<double, kRegressors, 1> regressor;
    regressor << 1.0, 2.0 * sample.time_s / duration_s_ - 1.0, std::cos(phase), std::sin(phase),
        has_dither ? std::cos(dither) : 0.0, has_dither ? std::sin(dither) : 0.0;
    normal_ += regressor * regressor.transpose();
    products_ += regressor * Eigen::Matrix<double, 1, kSignals>(sample.excitation_V, sample.e_W_V,
                                                                sample.current_A, sample.theta_rad);
}

BlockAmplitudes SweepBlock::amplitudes() const {
    Eigen::Matrix<double, kRegressors, kRegressors> normal = normal_;
    if (dither_rad_per_s_ <= 0.0) { // the last two are not in use
        normal(4, 4) = normal(5, 5) = 1.0;
    }
    const Eigen::Matrix<double, kRegressors, kSignals> found = normal.ldlt().solve(products_);
    const auto amplitude = [&](int signal) {
        // c cos ωt + s sin ωt = Re[(c − j s) e^(jωt)]
        return std::complex<double>(found(2, signal), -found(3, signal));
    };
    return {amplitude(0), amplitude(1), amplitude(2), amplitude(3)};
}

namespace {

using Complex = std::complex<double>;

/// What is known of an inductance before anything was measured: the file's, within such a share.
constexpr double kInductanceKnown = 0.5;
/// The same of k_T, if the file has no tolerance.
constexpr double kTorqueConstantKnown = 0.01;
constexpr double kMin_Ohm = 1e-3;

/// No point of a sweep is better known than that, for the fit of the winding.
constexpr double kMinDeviation = 2e-3;

/// Steps of the fit: each leaves less than a third of the error before.
constexpr int kFits = 12;

/// H(jω) of a command that is held for T, d T after its measurement.
Complex hold_and_delay(double omega_rad_per_s, double period_s, double delay_periods) {
    const Complex turn(0.0, omega_rad_per_s * period_s);
    return std::exp(-delay_periods * turn) * (1.0 - std::exp(-turn)) / turn;
}

/// C(e^(jωT)) of (10) with a locked set-point.
Complex law_V_per_rad(const loops::SpringDrive &drive, double omega_rad_per_s) {
    const double T = drive.period_s;
    const double a = control::velocity_filter_pole(drive.tuning.lambda_rad_per_s, T);
    const Complex back = std::polar(1.0, -omega_rad_per_s * T); // z⁻¹
    return drive.tuning.K_P_V_per_rad +
           drive.tuning.K_D_Vs_per_rad * (1.0 - a) * (1.0 - back) / (T * (1.0 - a * back));
}

/// The current by e_W at the samples relative to its component at ω alone, if the rotor were held:
/// it also moves within each period, and its aliases add up there.
Complex aliasing(const FittedWinding &winding, double omega_rad_per_s, double period_s,
                 double delay_periods) {
    const device::SplitDelay delay = device::split_delay(delay_periods);
    const double a = winding.dR_Ohm / winding.inductance_H;
    const double after_s = (1.0 - delay.fraction) * period_s; // the newer command acts
    const double before_s = delay.fraction * period_s;        // the one before it acts
    const Complex z = std::polar(1.0, omega_rad_per_s * period_s);
    const Complex newer = -std::expm1(-a * after_s);
    const Complex older = -std::expm1(-a * before_s) * std::exp(-a * after_s) / z;
    const Complex sampled = std::pow(z, -delay.whole) * (newer + older) /
                            (winding.dR_Ohm * (z - std::exp(-a * period_s)));
    const Complex impedance_Ohm(winding.dR_Ohm, omega_rad_per_s * winding.inductance_H);
    return sampled * impedance_Ohm / hold_and_delay(omega_rad_per_s, period_s, delay_periods);
}

/// The winding with the R̂ of one measurement.
FittedWinding during(const SweepMeasurement &measurement, FittedWinding winding) {
    winding.dR_Ohm =
        std::max(kMin_Ohm, winding.dR_Ohm + winding.cancelled_Ohm - measurement.cancelled_Ohm);
    winding.cancelled_Ohm = measurement.cancelled_Ohm;
    return winding;
}

/// What e_W of amplitude 1 V at ω adds to the sampled amplitudes by its aliases.
struct Aliases {
    Complex current_A;
    Complex theta_rad;
};

Aliases aliases(const loops::SpringDrive &drive, const SweepMeasurement &measurement,
                const FittedWinding &sweeps) {
    const FittedWinding winding = during(measurement, sweeps);
    const double T = drive.period_s;
    const double omega = measurement.omega_rad_per_s();
    const double k_T = winding.torque_constant_Nm_per_A;
    const double d = measurement.delay_periods;
    const Complex held_A =
        hold_and_delay(omega, T, d) / Complex(winding.dR_Ohm, omega * winding.inductance_H);
    Aliases found{(aliasing(winding, omega, T, d) - 1.0) * held_A, 0.0};
    // By the rotor's motion within the periods; terms fall with the third power of their number.
    constexpr int kTerms = 20;
    for (int m = -kTerms; m <= kTerms; ++m) {
        if (m == 0) {
            continue;
        }
        const double alias = omega + 2.0 * std::numbers::pi * m / T;
        const Complex held_Ohm(winding.dR_Ohm, alias * winding.inductance_H);
        const Complex moving_Ohm =
            held_Ohm + Complex(0.0, -k_T * k_T / (alias * winding.inertia_kg_m2));
        const Complex volts = hold_and_delay(alias, T, d);
        found.current_A += volts / moving_Ohm - volts / held_Ohm;
        found.theta_rad -= k_T * volts / moving_Ohm / (alias * alias * winding.inertia_kg_m2);
    }
    return found;
}

/// Amplitudes for one volt of excitation. Blocks may begin at any phase, so all are related to
/// their excitation, which is known without noise: means of ratios of noisy values would be biased.
struct Response {
    Complex e_W;     ///< [V/V]
    Complex current; ///< [A/V]
    Complex theta;   ///< [rad/V]
};

Response response_of(const BlockAmplitudes &block) {
    return {block.e_W_V / block.excitation_V, block.current_A / block.excitation_V,
            block.theta_rad / block.excitation_V};
}

Response mean_response(const SweepMeasurement &measurement) {
    Response sum;
    for (const BlockAmplitudes &block : measurement.blocks) {
        const Response its = response_of(block);
        sum.e_W += its.e_W;
        sum.current += its.current;
        sum.theta += its.theta;
    }
    const auto blocks = static_cast<double>(measurement.blocks.size());
    return {sum.e_W / blocks, sum.current / blocks, sum.theta / blocks};
}

/// A response at ω alone.
struct PureResponse {
    Complex net;     ///< what drives the current [V/V]
    Complex current; ///< [A/V]
    Complex theta;   ///< [rad/V]
};

PureResponse without_aliases(const loops::SpringDrive &drive, const SweepMeasurement &measurement,
                             const FittedWinding &winding, const Aliases &its_aliases,
                             const Response &response) {
    const double omega = measurement.omega_rad_per_s();
    const Complex theta = response.theta - its_aliases.theta_rad * response.e_W;
    return {hold_and_delay(omega, drive.period_s, measurement.delay_periods) * response.e_W -
                Complex(0.0, omega * winding.torque_constant_Nm_per_A) * theta,
            response.current - its_aliases.current_A * response.e_W, theta};
}

/// Y and its standard deviation.
struct Admittance {
    Complex value_S;
    double deviation = 0.0; ///< relative
};

Admittance admittance(const loops::SpringDrive &drive, const SweepMeasurement &measurement,
                      const FittedWinding &winding) {
    const Aliases its_aliases = aliases(drive, measurement, winding);
    const PureResponse mean =
        without_aliases(drive, measurement, winding, its_aliases, mean_response(measurement));
    const Complex Y = mean.current / mean.net;
    double scatter = 0.0;
    for (const BlockAmplitudes &block : measurement.blocks) {
        const PureResponse its =
            without_aliases(drive, measurement, winding, its_aliases, response_of(block));
        scatter += std::norm(its.current - Y * its.net);
    }
    // The mean of N residuals, of N − 1 degrees of freedom, for real and imaginary part each.
    const auto blocks = static_cast<double>(measurement.blocks.size());
    const double mean_deviation = blocks > 1.0
                                      ? std::sqrt(0.5 * scatter / (blocks * (blocks - 1.0)))
                                      : std::numeric_limits<double>::infinity();
    return {Y, mean_deviation / std::abs(mean.current)};
}

FittedWinding predicted_winding(const loops::SpringDrive &drive,
                                std::span<const SweepMeasurement> measurements) {
    double cancelled_Ohm = 0.0;
    for (const SweepMeasurement &measurement : measurements) {
        cancelled_Ohm += measurement.cancelled_Ohm / static_cast<double>(measurements.size());
    }
    return {drive.dR_Ohm(), cancelled_Ohm, drive.motor.inductance_H,
            drive.motor.torque_constant_Nm_per_A, std::numeric_limits<double>::infinity()};
}

/// A line y = a + b x through weighted points.
class FittedLine {
public:
    void take(double x, double y, double weight) {
        if (std::isfinite(weight) && std::isfinite(y)) {
            normal_ += weight * Eigen::Vector2d(1.0, x) * Eigen::RowVector2d(1.0, x);
            product_ += weight * y * Eigen::Vector2d(1.0, x);
        }
    }

    /// 0 if there are not two points.
    [[nodiscard]] double slope() const {
        return normal_.determinant() > 0.0 ? Eigen::Vector2d(normal_.inverse() * product_)[1] : 0.0;
    }

private:
    Eigen::Matrix2d normal_{Eigen::Matrix2d::Zero()};
    Eigen::Vector2d product_{Eigen::Vector2d::Zero()};
};

/// The inertia of K − J ω² that fits the load of all frequencies, each as well known as another; at
/// least that of the rotor.
double fitted_inertia_kg_m2(const loops::SpringDrive &drive,
                            std::span<const SweepMeasurement> measurements,
                            const FittedWinding &winding) {
    FittedLine load;
    for (const SweepMeasurement &measurement : measurements) {
        const double omega = measurement.omega_rad_per_s();
        const PureResponse pure =
            without_aliases(drive, measurement, winding, aliases(drive, measurement, winding),
                            mean_response(measurement));
        const Complex load_Nm_per_rad =
            winding.torque_constant_Nm_per_A * pure.current / pure.theta;
        load.take(-omega * omega, load_Nm_per_rad.real(), 1.0 / std::norm(load_Nm_per_rad));
    }
    return std::max(load.slope(), drive.motor.rotor_inertia_kg_m2);
}

/// Steps of the logarithms of dR, L and k_T.
using WindingStep = Eigen::Vector3d;

FittedWinding changed(FittedWinding winding, const WindingStep &step) {
    winding.dR_Ohm *= std::exp(step[0]);
    winding.inductance_H *= std::exp(step[1]);
    winding.torque_constant_Nm_per_A *= std::exp(step[2]);
    return winding;
}

/// The current that the motor would have at the samples, relative to the one measured.
Complex relative_current(const loops::SpringDrive &drive, const SweepMeasurement &measurement,
                         const FittedWinding &tried) {
    const Response measured = mean_response(measurement);
    const Aliases its_aliases = aliases(drive, measurement, tried);
    const PureResponse pure = without_aliases(drive, measurement, tried, its_aliases, measured);
    const Complex impedance_Ohm(during(measurement, tried).dR_Ohm,
                                measurement.omega_rad_per_s() * tried.inductance_H);
    return (pure.net / impedance_Ohm + its_aliases.current_A * measured.e_W) / measured.current;
}

/// A step of Gauss and Newton. What is fitted are the currents at the samples. They tell little of
/// L where they have settled, and little of k_T where the rotor hardly moves: the file's then hold.
WindingStep winding_step(const loops::SpringDrive &drive,
                         std::span<const SweepMeasurement> measurements,
                         const FittedWinding &winding) {
    constexpr double kSmall = 1e-4;
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    WindingStep product = WindingStep::Zero();
    for (const SweepMeasurement &measurement : measurements) {
        const Complex now = relative_current(drive, measurement, winding);
        Eigen::Vector3cd slope;
        for (Eigen::Index i = 0; i < slope.size(); ++i) {
            const FittedWinding beside = changed(winding, kSmall * WindingStep::Unit(i));
            slope[i] = (relative_current(drive, measurement, beside) - now) / kSmall;
        }
        const double deviation =
            std::max(admittance(drive, measurement, winding).deviation, kMinDeviation);
        const double weight = 1.0 / (deviation * deviation);
        if (!std::isfinite(std::abs(now)) || !std::isfinite(weight) || weight <= 0.0) {
            continue;
        }
        normal += weight * (slope.conjugate() * slope.transpose()).real();
        product += weight * (slope.conjugate() * (1.0 - now)).real();
    }
    const double known_k_T = std::max(drive.motor.torque_constant_tolerance, kTorqueConstantKnown);
    const auto know = [&](Eigen::Index i, double share, double file, double fitted) {
        normal(i, i) += 1.0 / (share * share);
        product[i] += std::log(file / fitted) / (share * share);
    };
    know(1, kInductanceKnown, drive.motor.inductance_H, winding.inductance_H);
    know(2, known_k_T, drive.motor.torque_constant_Nm_per_A, winding.torque_constant_Nm_per_A);
    if (!(normal.determinant() > 0.0)) {
        return WindingStep::Zero();
    }
    constexpr double kMax = 0.5;
    return WindingStep(normal.inverse() * product).cwiseMax(-kMax).cwiseMin(kMax);
}

/// What fits all frequencies best.
FittedWinding fitted_winding(const loops::SpringDrive &drive,
                             std::span<const SweepMeasurement> measurements) {
    FittedWinding winding = predicted_winding(drive, measurements);
    for (int fit = 0; fit < kFits; ++fit) {
        winding.inertia_kg_m2 = fitted_inertia_kg_m2(drive, measurements, winding);
        winding = changed(winding, winding_step(drive, measurements, winding));
        winding.dR_Ohm = std::max(winding.dR_Ohm, kMin_Ohm);
    }
    return winding;
}

SweepPoint point_of(loops::SpringDrive drive, const SweepMeasurement &measurement,
                    const FittedWinding &winding) {
    drive.delay_periods = measurement.delay_periods;
    const double omega = measurement.omega_rad_per_s();
    const double k_T = winding.torque_constant_Nm_per_A;
    const Admittance Y = admittance(drive, measurement, winding);
    // The law makes K_P and K_D larger where it takes k_T to be smaller.
    const double gain = drive.motor.torque_constant_Nm_per_A / measurement.torque_constant_Nm_per_A;
    const Complex to_voltage = gain * law_V_per_rad(drive, omega) *
                                   hold_and_delay(omega, drive.period_s, drive.delay_periods) +
                               Complex(0.0, omega * k_T);
    return {measurement.frequency_hz,
            k_T * Y.value_S * to_voltage,
            Y.deviation,
            loops::sampled_stiffness(drive, omega),
            loops::analytic_stiffness(drive, omega),
            measurement.delay_periods,
            measurement.excitation_V};
}

} // namespace

double SweepMeasurement::omega_rad_per_s() const { return 2.0 * std::numbers::pi * frequency_hz; }

double SweepPoint::magnitude_error() const {
    return std::abs(measured_Nm_per_rad) / std::abs(sampled_Nm_per_rad) - 1.0;
}

double SweepPoint::phase_error_rad() const {
    return std::arg(measured_Nm_per_rad / sampled_Nm_per_rad);
}

MotorSweep estimate_sweep(const loops::SpringDrive &drive,
                          std::span<const SweepMeasurement> measurements) {
    SPRINGDRIVE_ASSERT(!measurements.empty());
    MotorSweep sweep;
    sweep.motor = measurements.front().motor;
    sweep.winding = fitted_winding(drive, measurements);
    for (const SweepMeasurement &measurement : measurements) {
        sweep.points.push_back(point_of(drive, measurement, sweep.winding));
    }
    std::ranges::sort(sweep.points, {}, &SweepPoint::frequency_hz);
    return sweep;
}

double estimated_deviation(const loops::SpringDrive &drive, const SweepMeasurement &measurement) {
    return admittance(drive, measurement, predicted_winding(drive, {&measurement, 1})).deviation;
}

} // namespace springdrive::commissioning
