#include "engine/lab/limits/method_limits/limit_trials.h"

#include "base/bisection.h"
#include "base/degrees.h"
#include "device/core/motor/amplifier.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/motion_control.h"
#include "engine/control/perception.h"
#include "engine/lab/loops/direction_spectrum.h"
#include "engine/lab/rig/law_rig.h"

#include <Eigen/LU>

#include <fmt/core.h>

#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <utility>

namespace springdrive::limits {

namespace {

constexpr double kMin_hz = 1.0;
constexpr double kMax_hz = 200.0;

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
    return kDegreesPerRadian *
           loops::worst_direction_error_rad(loops::tip_stiffness(
               contact, control::MotionMap::transpose, rate_rad_per_s(frequency_hz)));
}

/// Windings of motors whose rotors are locked, except for one that vibrates.
class VibratingRotors final : public rig::Plant {
public:
    static constexpr double kAmplitude_rad = 1e-5; ///< so small that J is constant

    /// Receives the currents at the end of each sub-step.
    using Watch = std::function<void(double time_s, const Vector3 &current_A)>;

    VibratingRotors(const device::DeviceDescription &device, const Vector3 &rest_rad,
                    Eigen::Index shaken, double omega_rad_per_s, double period_s, Watch watch)
        : device_(device), rest_rad_(rest_rad), shaken_(shaken), omega_(omega_rad_per_s),
          period_s_(period_s), watch_(std::move(watch)) {}

    [[nodiscard]] double time_s() const { return static_cast<double>(periods_) * period_s_; }
    [[nodiscard]] Vector3 theta_rad() const override { return theta_rad(time_s()); }

    void advance(const simulated::PlantCommand &command) override {
        constexpr int kSubSteps = 10;
        const double h = period_s_ / kSubSteps;
        for (int sub = 0; sub < kSubSteps; ++sub) {
            const double before_s = time_s() + sub * h;
            step(command.spring_drive, before_s, h);
            watch_(before_s + h, current_A_);
        }
        ++periods_;
    }

private:
    [[nodiscard]] Vector3 theta_rad(double time_s) const {
        Vector3 theta = rest_rad_;
        theta[shaken_] += kAmplitude_rad * std::cos(omega_ * time_s);
        return theta;
    }

    void step(const device::DeviceCommand &command, double before_s, double h) {
        const Vector3 rate = (theta_rad(before_s + h) - theta_rad(before_s)) / h;
        for (Eigen::Index j = 0; j < 3; ++j) {
            const device::MotorParameters &motor = device_.motor[static_cast<std::size_t>(j)];
            const device::DriveState now{motor.resistance_Ohm, current_A_[j], rate[j], true};
            current_A_[j] = device::spring_drive_step(motor, now, command.e_W_V[j],
                                                      command.cancelled_resistance_Ohm[j], h)
                                .end_at(rate[j]);
        }
    }

    const device::DeviceDescription &device_;
    Vector3 rest_rad_;
    Eigen::Index shaken_;
    double omega_;
    double period_s_;
    Watch watch_;
    long periods_ = 0;
    Vector3 current_A_{Vector3::Zero()};
};

/// −τ of all motors per angle of the vibrating one while the law holds the tip at a point, as a
/// phasor [N·m/rad]. After the initial transient, the current's component at ω is weighted by a
/// Hann window, which suppresses all other frequencies.
Eigen::Vector3cd motor_stiffness(const loops::StabilityCase &which, Eigen::Index shaken,
                                 double omega_rad_per_s) {
    constexpr double kSettles_s = 0.05;
    constexpr double kWatched_s = 0.4;
    Eigen::Vector3cd sum = Eigen::Vector3cd::Zero();
    double weights = 0.0;
    const auto correlate = [&](double time_s, const Vector3 &current_A) {
        const double share = (time_s - kSettles_s) / kWatched_s;
        const double weight = share > 0.0 ? 1.0 - std::cos(2.0 * std::numbers::pi * share) : 0.0;
        sum += weight * std::polar(1.0, -omega_rad_per_s * time_s) *
               current_A.cast<std::complex<double>>();
        weights += weight;
    };
    rig::LawOptions law;
    law.device = which.device;
    law.period_s = which.period_s;
    law.rests_at_rad = device::motor_from_joint(which.device.geometry, which.q_rad);
    VibratingRotors rotors(which.device, *law.rests_at_rad, shaken, omega_rad_per_s, which.period_s,
                           correlate);
    rig::LawRig loop(rotors, law,
                     rig::tied_to(device::tip_position_m(which.device.geometry, which.q_rad)),
                     rig::FirstCommand::answers);
    while (rotors.time_s() < kSettles_s + kWatched_s) {
        loop.tick();
    }
    // A cosine of that amplitude has half of it at ω.
    return -2.0 / (weights * VibratingRotors::kAmplitude_rad) *
           control::torque_constants(which.device).cast<std::complex<double>>().cwiseProduct(sum);
}

double measured_deg(const loops::StabilityCase &which, double frequency_hz) {
    Eigen::Matrix2cd per_motor;
    for (Eigen::Index j = 0; j < 2; ++j) {
        per_motor.col(j) = motor_stiffness(which, j + 1, rate_rad_per_s(frequency_hz)).tail<2>();
    }
    const Eigen::Matrix2cd J_inverse =
        loops::Matrix2(loops::planar_jacobian(which.device.geometry, which.q_rad).inverse())
            .cast<std::complex<double>>();
    return kDegreesPerRadian *
           loops::worst_direction_error_rad(J_inverse.transpose() * per_motor * J_inverse);
}

} // namespace

LimitTrial direction_trial(const loops::StabilityCase &which) {
    const loops::PlanarContact contact = planar_contact(which);
    const double predicted_hz =
        last_that_holds({kMin_hz, kMax_hz}, kLimitResolution, [&](double frequency_hz) {
            return predicted_deg(contact, frequency_hz) < control::kNoticeable_deg;
        });
    return {
        {kTransposeKinematics,
         "wrong force direction above",
         "Hz",
         fmt::format(
             "force of a vibration {:g}° off the worst normal, tuning firm, 1 kHz; λ is {}",
             control::kNoticeable_deg,
             with_unit(std::round(control::Tuning{}.lambda_rad_per_s / (2.0 * std::numbers::pi)),
                       "Hz")),
         predicted_hz,
         {},
         {}},
        kMin_hz,
        kMax_hz,
        false,
        [=](double frequency_hz) {
            return measured_deg(which, frequency_hz) < control::kNoticeable_deg;
        }};
}

} // namespace springdrive::limits
