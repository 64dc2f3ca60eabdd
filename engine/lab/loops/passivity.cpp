#include "engine/lab/loops/passivity.h"

#include "engine/control/velocity_filter.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

namespace springdrive::loops {

namespace {

using PortComplex = std::complex<double>;

constexpr double kNever = -std::numeric_limits<double>::infinity();

/// What both conditions are made of, at one ω.
class PortSums {
public:
    PortSums(const SpringDrive &drive, const Port &port, double omega_rad_per_s)
        : k_T_(drive.motor.torque_constant_Nm_per_A), L_(drive.motor.inductance_H),
          dR_(drive.dR_Ohm()), b_(port.damping_Nms_per_rad), T_(drive.period_s),
          d_(drive.delay_periods), omega_(omega_rad_per_s), D_(dR_ * (k_T_ * k_T_ + b_ * dR_)),
          p_(std::sqrt(D_ / b_) / L_), z1_(std::polar(1.0, -omega_ * T_)) {
        const double pole = control::velocity_filter_pole(drive.tuning.lambda_rad_per_s, T_);
        const PortComplex rate = (1.0 - pole) * (1.0 - z1_) / (T_ * (1.0 - pole * z1_));
        C_ = port.held * (drive.tuning.K_P_V_per_rad + drive.tuning.K_D_Vs_per_rad * rate) -
             (1.0 - port.held) * k_T_ * rate;
        const double half = std::sin(0.5 * omega_ * T_);
        of_zero_ = T_ * T_ / (4.0 * half * half);
        // sinh pT/(cosh pT − cos ωT), without its overflow where pT is large
        const double fades = std::exp(-p_ * T_);
        of_p_ = T_ / (2.0 * p_) * (1.0 - fades * fades) /
                (1.0 + fades * fades - 2.0 * fades * std::cos(omega_ * T_));
    }

    /// Σ|c|²/g
    [[nodiscard]] double of_c() const {
        return dR_ * dR_ / D_ * of_zero_ + (1.0 / b_ - dR_ * dR_ / D_) * of_p_;
    }

    /// Σ|q|²/g
    [[nodiscard]] double of_q() const {
        return std::norm(C_ * (1.0 - z1_)) * k_T_ * k_T_ / (T_ * T_ * D_) * (of_zero_ - of_p_);
    }

    /// Σ c̄q/g
    [[nodiscard]] PortComplex of_both() const {
        const double first = std::ceil(d_); // sample that the voltage of this one reaches first
        const double rest = first - d_;
        const PortComplex one_less = 1.0 - z1_;
        const double fades = std::exp(-p_ * T_);
        const PortComplex after =
            dR_ * T_ * (rest / one_less + z1_ / (one_less * one_less)) - L_ / one_less +
            0.5 * (dR_ / p_ + L_) * std::exp(-p_ * rest * T_) / (1.0 - fades * z1_);
        const PortComplex before = 0.5 * (dR_ / p_ - L_) * std::exp(-p_ * (1.0 - rest) * T_) /
                                   (1.0 - fades * std::conj(z1_)) * std::conj(z1_);
        return C_ * one_less * (k_T_ / D_) * std::pow(z1_, first) * (after + before);
    }

    /// Σ|c q|/g: up to 30 p, and what is beyond at most.
    [[nodiscard]] double of_magnitudes() const {
        const double spacing = 2.0 * std::numbers::pi / T_;
        const auto terms = static_cast<long>(std::min(1e5, std::ceil(30.0 * p_ / spacing) + 10.0));
        double sum = 0.0;
        for (long n = -terms; n <= terms; ++n) {
            const double square = std::pow(omega_ + static_cast<double>(n) * spacing, 2);
            sum +=
                std::sqrt(dR_ * dR_ + L_ * L_ * square) / (square * (D_ + b_ * L_ * L_ * square));
        }
        const double last = (static_cast<double>(terms) - 0.5) * spacing;
        // √(dR² + L²Ω²) < 1.1 LΩ there, each side ∫ dΩ/spacing
        sum += 2.0 * 1.1 / (2.0 * b_ * L_ * last * last * spacing);
        return std::abs(C_ * (1.0 - z1_)) * k_T_ / T_ * sum;
    }

private:
    double k_T_;
    double L_;
    double dR_;
    double b_;
    double T_;
    double d_;
    double omega_;
    double D_;
    double p_;
    PortComplex z1_; ///< e^(−jωT)
    PortComplex C_;
    double of_zero_; ///< Σ 1/Ω_n²
    double of_p_;    ///< Σ 1/(Ω_n² + p²)
};

SpringDrive drive_of(const StabilityCase &which, std::size_t motor) {
    SpringDrive drive{which.device.motor[motor], which.tuning, which.period_s, which.delay_periods};
    // As it is, not as far as a drive can be set: with nothing left, nothing is passive.
    const double dR_Ohm = std::max(0.0, which.dR_Ohm(which.device.motor[motor]));
    drive.motor.resistance_Ohm = drive.tuning.dR_Ohm = dR_Ohm;
    return drive;
}

/// The least b of all motors and structures.
double port_damping_Nms_per_rad(const StabilityCase &which) {
    if (which.rotor) {
        return which.rotor->damping_Nms_per_rad;
    }
    const Vector3 joint = which.device.friction.viscous_Nms_per_rad *
                          which.device.geometry.transmission_ratio.cwiseAbs2().cwiseInverse();
    double least = joint.minCoeff();
    for (const Structure &structure : which.structures) {
        const auto cables = device::cable_compliance(which.device, structure.in_cable());
        for (std::size_t j = 0; structure.in_cable() > 0.0 && j < cables.size(); ++j) {
            const double c = cables[j].damping_Nms_per_rad;
            const double b = joint[static_cast<Eigen::Index>(j)];
            least = std::min(least, c > 0.0 ? b / (1.0 + b / c) : 0.0);
        }
    }
    return least;
}

using OfDrive = LeastAtPort(const SpringDrive &, double);

/// Of the worst motor; each of those that differ is taken by itself.
LeastAtPort worst_of_motors(const StabilityCase &which, OfDrive *of_drive) {
    const double b = port_damping_Nms_per_rad(which);
    const std::size_t first = which.rotor ? 1 : 0; // the one that members have
    const SpringDrive drive = drive_of(which, first);
    LeastAtPort least = of_drive(drive, b);
    for (std::size_t j = 1; !which.rotor && j < which.device.motor.size(); ++j) {
        const SpringDrive other = drive_of(which, j);
        if (other.dR_Ohm() == drive.dR_Ohm() &&
            other.motor.inductance_H == drive.motor.inductance_H &&
            other.motor.torque_constant_Nm_per_A == drive.motor.torque_constant_Nm_per_A) {
            continue;
        }
        const LeastAtPort found = of_drive(other, b);
        least = found.value < least.value ? found : least;
    }
    return least;
}

bool has_losses(const SpringDrive &drive, const Port &port) {
    return drive.dR_Ohm() > 0.0 && port.damping_Nms_per_rad > 0.0;
}

using AtPort = double(const SpringDrive &, const Port &, double);

/// Evenly in the frequency's logarithm, then more closely around the least of each a.
LeastAtPort least(const SpringDrive &drive, double damping_Nms_per_rad, AtPort *value,
                  std::span<const double> held, int points) {
    constexpr double kDecades = 4.0;
    const double highest = std::numbers::pi / drive.period_s;
    const double step = std::pow(10.0, kDecades / points);
    LeastAtPort least_of_all{std::numeric_limits<double>::infinity(), highest, 1.0};
    for (const double a : held) {
        LeastAtPort found{std::numeric_limits<double>::infinity(), highest, a};
        const auto look_at = [&](double omega) {
            const double here = value(drive, {damping_Nms_per_rad, a}, omega);
            if (!(here >= found.value)) {
                found = {std::isnan(here) ? kNever : here, omega, a}; // not known: does not hold
            }
        };
        for (int i = 0; i <= points; ++i) {
            look_at(highest * std::pow(step, -i));
        }
        const double centre = found.omega_rad_per_s;
        for (int i = -10; i <= 10; ++i) {
            look_at(std::min(highest, centre * std::pow(step, 0.1 * i)));
        }
        if (found.value < least_of_all.value) {
            least_of_all = found;
        }
    }
    return least_of_all;
}

} // namespace

double least_absorbed(const SpringDrive &drive, const Port &port, double omega_rad_per_s) {
    if (!has_losses(drive, port)) {
        return kNever;
    }
    const PortSums sums(drive, port, omega_rad_per_s);
    const PortComplex both = sums.of_both();
    const double root = sums.of_q() * sums.of_c() - both.imag() * both.imag();
    return 1.0 + 0.5 * (both.real() - std::sqrt(std::max(0.0, root)));
}

double distance_to_linear_hands(const SpringDrive &drive, const Port &port,
                                double omega_rad_per_s) {
    if (!has_losses(drive, port)) {
        return kNever;
    }
    const PortSums sums(drive, port, omega_rad_per_s);
    return std::abs(1.0 + 0.5 * sums.of_both()) - 0.5 * sums.of_magnitudes();
}

LeastAtPort passivity(const SpringDrive &drive, double damping_Nms_per_rad) {
    return least(drive, damping_Nms_per_rad, least_absorbed, std::array{1.0, 0.0}, 200);
}

LeastAtPort stability_with_linear_hands(const SpringDrive &drive, double damping_Nms_per_rad) {
    return least(drive, damping_Nms_per_rad, distance_to_linear_hands,
                 std::array{1.0, 0.9, 0.75, 0.5, 0.25, 0.1, 0.03, 0.0}, 100);
}

LeastAtPort passivity(const StabilityCase &which) { return worst_of_motors(which, passivity); }

LeastAtPort stability_with_linear_hands(const StabilityCase &which) {
    return worst_of_motors(which, stability_with_linear_hands);
}

std::string port_text(const LeastAtPort &passive, const LeastAtPort &linear_hands) {
    if (passive.holds()) {
        return "passive";
    }
    const LeastAtPort &worst = linear_hands.holds() ? passive : linear_hands;
    const std::string where =
        fmt::format("active at {:.3g} Hz {}", worst.omega_rad_per_s / (2.0 * std::numbers::pi),
                    worst.held == 0.0   ? "in free space"
                    : worst.held == 1.0 ? "in contact"
                                        : fmt::format("at η {:.3g}", 1.0 - worst.held));
    return linear_hands.holds() ? "stable with every linear hand, " + where
                                : where + ", and unstable with some hand";
}

} // namespace springdrive::loops
