#include "engine/lab/limits/failure_lines/direction_line.h"

#include "base/bisection.h"
#include "device/core/motor/amplifier.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/haptic_law.h"
#include "engine/control/velocity_filter.h"
#include "engine/lab/loops/direction_spectrum.h"

#include <Eigen/LU>

#include <cmath>
#include <complex>
#include <numbers>

namespace springdrive::limits {

namespace {

constexpr double kPerceptible_deg = 25.0; ///< section V of the paper
constexpr double kLowest_hz = 1.0;
constexpr double kHighest_hz = 200.0;

double degrees(double angle_rad) { return angle_rad * 180.0 / std::numbers::pi; }
double rate_rad_per_s(double frequency_hz) { return 2.0 * std::numbers::pi * frequency_hz; }

loops::PlanarContact planar_contact(const loops::StabilityCase &which) {
    const device::DeviceDescription &device = which.device;
    const Vector3 W = control::relative_stiffness(device);
    loops::PlanarContact contact;
    contact.J = loops::planar_jacobian(device.geometry, which.q_rad);
    contact.alpha_rad2_per_m2 =
        control::alpha_bound(device::motor_jacobian(device.geometry, which.q_rad), W);
    contact.relative_stiffness = W.tail<2>();
    for (std::size_t j = 0; j < 2; ++j) {
        contact.drive[j] = {device.motor[j + 1], control::Tuning{}, which.period_s,
                            which.delay_periods};
    }
    return contact;
}

double predicted_deg(const loops::PlanarContact &contact, double frequency_hz) {
    return degrees(loops::worst_direction_error_rad(loops::tip_stiffness(
        contact, control::MotionMap::transpose, rate_rad_per_s(frequency_hz))));
}

/// Motors that are shaken while the law holds the tip at a point.
class ShakenMotors {
public:
    ShakenMotors(const loops::StabilityCase &which, double omega_rad_per_s)
        : which_(which), law_(which.device),
          rest_rad_(device::motor_from_joint(which.device.geometry, which.q_rad)),
          omega_(omega_rad_per_s) {
        tie_.touching = true;
        tie_.x0_m = device::tip_position_m(which.device.geometry, which.q_rad);
        tie_.allowed_motion.setZero();
        tie_.eta = 0.0;
    }

    /// −τ of all motors per way of one, as a phasor [N·m/rad]. Once what the start left has died
    /// out, the current's part at ω is weighed by a Hann window, which is deaf to all else.
    [[nodiscard]] Eigen::Vector3cd stiffness(Eigen::Index shaken) {
        constexpr double kSettles_s = 0.05;
        constexpr double kWatched_s = 0.4;
        filter_.reset(rest_rad_);
        current_A_.setZero();
        Eigen::Vector3cd sum = Eigen::Vector3cd::Zero();
        double weights = 0.0;
        const double h = which_.period_s / kSubSteps;
        for (long tick = 0; static_cast<double>(tick) * which_.period_s < kSettles_s + kWatched_s;
             ++tick) {
            const double start_s = static_cast<double>(tick) * which_.period_s;
            const device::DeviceCommand command = command_at(theta_rad(shaken, start_s));
            for (int sub = 0; sub < kSubSteps; ++sub) {
                const double before_s = start_s + sub * h;
                carry_on(command, shaken, before_s, h);
                const double share = (before_s + h - kSettles_s) / kWatched_s;
                const double weight =
                    share > 0.0 ? 1.0 - std::cos(2.0 * std::numbers::pi * share) : 0.0;
                sum += weight * std::polar(1.0, -omega_ * (before_s + h)) *
                       current_A_.cast<std::complex<double>>();
                weights += weight;
            }
        }
        // A cosine of that amplitude has half of it at ω.
        return -2.0 / (weights * kAmplitude_rad) *
               law_.k_T().cast<std::complex<double>>().cwiseProduct(sum);
    }

private:
    static constexpr int kSubSteps = 10;
    static constexpr double kAmplitude_rad = 1e-5; ///< so small that J stands still

    [[nodiscard]] Vector3 theta_rad(Eigen::Index shaken, double time_s) const {
        Vector3 theta = rest_rad_;
        theta[shaken] += kAmplitude_rad * std::cos(omega_ * time_s);
        return theta;
    }

    [[nodiscard]] device::DeviceCommand command_at(const Vector3 &theta) {
        const control::Tuning tuning;
        const double pole = control::velocity_filter_pole(tuning.lambda_rad_per_s, which_.period_s);
        const control::Configuration now =
            law_.configuration(theta, filter_.update(theta, pole, which_.period_s));
        return law_(now, tie_, tuning, 0.0).command;
    }

    void carry_on(const device::DeviceCommand &command, Eigen::Index shaken, double before_s,
                  double h) {
        const Vector3 rate = (theta_rad(shaken, before_s + h) - theta_rad(shaken, before_s)) / h;
        for (Eigen::Index j = 0; j < 3; ++j) {
            const device::MotorParameters &motor = which_.device.motor[static_cast<std::size_t>(j)];
            const device::DriveState now{motor.resistance_Ohm, current_A_[j], rate[j], true};
            current_A_[j] = device::spring_drive_step(motor, now, command.e_W_V[j],
                                                      command.cancelled_resistance_Ohm[j], h)
                                .end_at(rate[j]);
        }
    }

    const loops::StabilityCase &which_;
    control::HapticLaw law_;
    Vector3 rest_rad_;
    double omega_;
    control::VelocityFilter filter_;
    contact::Contact tie_;
    Vector3 current_A_{Vector3::Zero()};
};

double measured_deg(const loops::StabilityCase &which, double frequency_hz) {
    ShakenMotors motors(which, rate_rad_per_s(frequency_hz));
    Eigen::Matrix2cd per_motor;
    for (Eigen::Index j = 0; j < 2; ++j) {
        per_motor.col(j) = motors.stiffness(j + 1).tail<2>();
    }
    const Eigen::Matrix2cd J_inverse =
        loops::Matrix2(loops::planar_jacobian(which.device.geometry, which.q_rad).inverse())
            .cast<std::complex<double>>();
    return degrees(loops::worst_direction_error_rad(J_inverse.transpose() * per_motor * J_inverse));
}

} // namespace

TriedLine direction_line(const loops::StabilityCase &which) {
    const loops::PlanarContact contact = planar_contact(which);
    const double predicted_hz =
        last_that_holds({kLowest_hz, kHighest_hz}, kLineResolution, [&](double frequency_hz) {
            return predicted_deg(contact, frequency_hz) < kPerceptible_deg;
        });
    return {
        {"transpose kinematics (23)",
         "directions of force above",
         "Hz",
         "vibration turned by 25° from the worst normal, tuning firm, 1 kHz; λ is " +
             with_unit(std::round(control::Tuning{}.lambda_rad_per_s / (2.0 * std::numbers::pi)),
                       "Hz"),
         predicted_hz,
         {},
         {}},
        kLowest_hz,
        kHighest_hz,
        false,
        [=](double frequency_hz) { return measured_deg(which, frequency_hz) < kPerceptible_deg; }};
}

} // namespace springdrive::limits
