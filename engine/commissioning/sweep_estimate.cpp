#include "engine/commissioning/sweep_estimate.h"

#include "base/assertions.h"
#include "device/core/split_delay.h"
#include "engine/control/velocity_filter.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace springdrive::commissioning {

namespace {

using Complex = std::complex<double>;

/// What is known of an inductance before anything was measured: the file's, within such a share.
constexpr double kInductanceKnown = 0.5;
constexpr double kLeast_Ohm = 1e-3;

/// No point of a sweep is better known than that, for the fit of the winding.
constexpr double kLeastDeviation = 2e-3;

/// Of the winding and its aliases: each one leaves a twentieth of the error before.
constexpr int kFits = 8;

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

/// What e_W of amplitude 1 V at ω adds to the sampled amplitudes by its aliases.
struct Aliases {
    Complex current_A;
    Complex theta_rad;
};

Aliases aliases(const loops::SpringDrive &drive, const SweepMeasurement &measurement,
                const FittedWinding &winding) {
    const double T = drive.period_s;
    const double omega = measurement.omega_rad_per_s();
    const double k_T = measurement.torque_constant_Nm_per_A;
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

/// Y and its standard deviation.
struct Admittance {
    Complex value_S;
    double deviation = 0.0; ///< relative
};

/// A block's amplitudes at ω alone, related to its excitation.
struct PureAmplitudes {
    Complex net;     ///< the voltage that drives the current
    Complex current; ///< [1/Ω]
};

/// Blocks may begin at any phase, so all are related to their excitation, which is known without
/// noise: means of ratios of noisy values would be biased.
Admittance admittance(const loops::SpringDrive &drive, const SweepMeasurement &measurement,
                      const FittedWinding &winding) {
    const double omega = measurement.omega_rad_per_s();
    const Complex H = hold_and_delay(omega, drive.period_s, measurement.delay_periods);
    const Complex back_emf_Vs(0.0, omega * measurement.torque_constant_Nm_per_A);
    const Aliases its_aliases = aliases(drive, measurement, winding);
    const auto pure = [&](const BlockAmplitudes &block) -> PureAmplitudes {
        const Complex theta_rad = block.theta_rad - its_aliases.theta_rad * block.e_W_V;
        const Complex current_A = block.current_A - its_aliases.current_A * block.e_W_V;
        return {(H * block.e_W_V - back_emf_Vs * theta_rad) / block.excitation_V,
                current_A / block.excitation_V};
    };
    PureAmplitudes sum;
    for (const BlockAmplitudes &block : measurement.blocks) {
        const PureAmplitudes its = pure(block);
        sum.net += its.net;
        sum.current += its.current;
    }
    const auto blocks = static_cast<double>(measurement.blocks.size());
    const Complex Y = sum.current / sum.net;
    double scatter = 0.0;
    for (const BlockAmplitudes &block : measurement.blocks) {
        const PureAmplitudes its = pure(block);
        scatter += std::norm(its.current - Y * its.net);
    }
    // The mean of N residuals, of N − 1 degrees of freedom, for real and imaginary part each.
    const double mean_deviation = blocks > 1.0
                                      ? std::sqrt(0.5 * scatter / (blocks * (blocks - 1.0)))
                                      : std::numeric_limits<double>::infinity();
    return {Y, mean_deviation / std::abs(sum.current / blocks)};
}

/// From the torque that moved it: K − J ω² of hand and linkage at all frequencies, each as well
/// known as another.
double fitted_inertia_kg_m2(const loops::SpringDrive &drive,
                            std::span<const SweepMeasurement> measurements) {
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d product = Eigen::Vector2d::Zero();
    for (const SweepMeasurement &measurement : measurements) {
        Complex torque_Nm = 0.0;
        Complex theta_rad = 0.0;
        for (const BlockAmplitudes &block : measurement.blocks) {
            torque_Nm +=
                measurement.torque_constant_Nm_per_A * block.current_A / block.excitation_V;
            theta_rad += block.theta_rad / block.excitation_V;
        }
        const Complex load_Nm_per_rad = torque_Nm / theta_rad;
        const double omega = measurement.omega_rad_per_s();
        const Eigen::Vector2d regressor(1.0, -omega * omega);
        const double weight = 1.0 / std::norm(load_Nm_per_rad);
        if (std::isfinite(weight)) {
            normal += weight * regressor * regressor.transpose();
            product += weight * load_Nm_per_rad.real() * regressor;
        }
    }
    const double J =
        normal.determinant() > 0.0 ? Eigen::Vector2d(normal.inverse() * product)[1] : 0.0;
    return std::max(std::isfinite(J) ? J : 0.0, drive.motor.rotor_inertia_kg_m2);
}

FittedWinding predicted_winding(const loops::SpringDrive &drive) {
    return {drive.dR_Ohm(), drive.motor.inductance_H, std::numeric_limits<double>::infinity()};
}

/// dR + jωL that fits 1/Y of all frequencies best.
FittedWinding fitted_winding(const loops::SpringDrive &drive,
                             std::span<const SweepMeasurement> measurements) {
    FittedWinding winding = predicted_winding(drive);
    winding.inertia_kg_m2 = fitted_inertia_kg_m2(drive, measurements);
    const double known_H = kInductanceKnown * drive.motor.inductance_H;
    for (int fit = 0; fit < kFits; ++fit) {
        double weights = 0.0;
        double resistances = 0.0;
        double squares = 1.0 / (known_H * known_H);
        double inductances = drive.motor.inductance_H * squares;
        for (const SweepMeasurement &measurement : measurements) {
            const Admittance Y = admittance(drive, measurement, winding);
            const Complex impedance_Ohm = 1.0 / Y.value_S;
            const double deviation_Ohm =
                std::abs(impedance_Ohm) * std::max(Y.deviation, kLeastDeviation);
            const double weight = 1.0 / (deviation_Ohm * deviation_Ohm);
            if (!std::isfinite(weight) || !(weight > 0.0)) {
                continue;
            }
            const double omega = measurement.omega_rad_per_s();
            weights += weight;
            resistances += weight * impedance_Ohm.real();
            squares += weight * omega * omega;
            inductances += weight * omega * impedance_Ohm.imag();
        }
        if (weights > 0.0) {
            winding.dR_Ohm = std::max(resistances / weights, kLeast_Ohm);
        }
        // An amplifier's own delay may look like a lack of inductance.
        winding.inductance_H = std::clamp(inductances / squares, 0.1 * drive.motor.inductance_H,
                                          10.0 * drive.motor.inductance_H);
    }
    return winding;
}

SweepPoint point_of(loops::SpringDrive drive, const SweepMeasurement &measurement,
                    const FittedWinding &winding) {
    drive.delay_periods = measurement.delay_periods;
    const double omega = measurement.omega_rad_per_s();
    const double k_T = measurement.torque_constant_Nm_per_A;
    const Admittance Y = admittance(drive, measurement, winding);
    // The law makes K_P and K_D larger where k_T is smaller.
    const double gain = drive.motor.torque_constant_Nm_per_A / k_T;
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
        sweep.torque_constant_Nm_per_A +=
            measurement.torque_constant_Nm_per_A / static_cast<double>(measurements.size());
    }
    std::ranges::sort(sweep.points, {}, &SweepPoint::frequency_hz);
    return sweep;
}

double estimated_deviation(const loops::SpringDrive &drive, const SweepMeasurement &measurement) {
    return admittance(drive, measurement, predicted_winding(drive)).deviation;
}

} // namespace springdrive::commissioning
