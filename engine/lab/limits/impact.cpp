#include "engine/lab/limits/impact.h"

#include "device/core/phantom/kinematics.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/control/force_direction.h"
#include "engine/control/haptic_law.h"
#include "engine/control/velocity_filter.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace springdrive::limits {

namespace {

/// A level wall under the tip, and what the servo makes of it.
class WallServo {
public:
    WallServo(const loops::StabilityCase &which, const device::DeviceDescription &device,
              double height_m)
        : which_(which), law_(device), global_alpha_(control::global_alpha_bound(which.device)),
          height_m_(height_m) {}

    void rest_at(const Vector3 &theta_rad) { filter_.reset(theta_rad); }

    [[nodiscard]] simulated::PlantCommand command(const std::array<std::int32_t, 3> &counts) {
        const Vector3 theta_rad = law_.theta_rad(counts);
        const Vector3 rate = filter_.update(
            theta_rad,
            control::velocity_filter_pole(which_.tuning.lambda_rad_per_s, which_.period_s),
            which_.period_s);
        const control::Configuration now = law_.configuration(theta_rad, rate);
        if (which_.drive == device::AmplifierKind::current_drive) {
            return {device::DeviceCommand::braking(), current_A(now)};
        }
        return {spring(now), Vector3::Zero()};
    }

private:
    [[nodiscard]] bool is_below(const control::Configuration &now) const {
        return now.tip_m.y() < height_m_;
    }

    [[nodiscard]] device::DeviceCommand spring(const control::Configuration &now) const {
        contact::Contact contact;
        contact.x0_m = now.tip_m;
        if (is_below(now)) {
            contact.touching = true;
            contact.x0_m.y() = height_m_;
            contact.normal = Vector3::UnitY();
            contact.allowed_motion =
                Matrix3::Identity() - Vector3::UnitY() * Vector3::UnitY().transpose();
            contact.eta = 0.0;
        }
        return law_(now, contact, which_.tuning, global_alpha_).command;
    }

    [[nodiscard]] Vector3 current_A(const control::Configuration &now) const {
        if (is_below(now)) {
            const double push_N = which_.wall.stiffness_N_per_m * (height_m_ - now.tip_m.y()) -
                                  which_.wall.damping_Ns_per_m * now.tip_velocity_m_per_s().y();
            // A wall does not pull.
            const Vector3 force_N = std::max(0.0, push_N) * Vector3::UnitY();
            return Vector3(now.J.transpose() * force_N).cwiseQuotient(law_.k_T());
        }
        return Vector3::Zero();
    }

    const loops::StabilityCase &which_;
    control::HapticLaw law_;
    double global_alpha_;
    double height_m_;
    control::VelocityFilter filter_;
};

simulated::SimulationOptions options_of(const loops::StabilityCase &which,
                                        std::vector<simulated::HandPath::Point> path) {
    const loops::Hand hand =
        which.hands.empty() ? loops::hand_of_firmness(0.5) : which.hands.front();
    simulated::SimulationOptions options;
    options.servo_period_s = which.period_s;
    options.delay_periods = which.delay_periods;
    options.hand = {hand.mass_kg, hand.damping_Ns_per_m, hand.stiffness_N_per_m, HUGE_VAL, 1.0};
    options.path = simulated::HandPath(std::move(path));
    options.effects.gravity = false; // a balanced arm: weight is none of the drive's
    options.effects.coulomb_friction = false;
    options.effects.winding_heat = false;
    options.effects.commutation_ripple = false;
    options.amplifier = which.drive;
    options.longest_step_s = 50e-6;
    return options;
}

/// Force of the motors along the vertical.
double motors_push_N(const loops::StabilityCase &which,
                     const simulated::SimulatedPhantom &phantom) {
    const simulated::SimulatedPhantom::Truth &truth = phantom.truth();
    const device::PhantomGeometry &geometry = which.device.geometry;
    const Matrix3 J =
        device::motor_jacobian(geometry, device::joint_from_motor(geometry, truth.theta_rad));
    const Vector3 torque_Nm = control::torque_constants(which.device).cwiseProduct(truth.current_A);
    return (J.transpose().inverse() * torque_Nm).y();
}

/// One impact on a wall that is `lower_m` farther down than where the approach usually ends.
Impact impact_at(const loops::StabilityCase &which, double speed_m_per_s, double lower_m) {
    constexpr double kApproach_s = 0.1; // until hand and tip move as one
    constexpr double kLongestApproach_s = 1.0;
    constexpr double kSoonest_s = 0.001;
    constexpr double kWatched_s = 0.01;
    const Vector3 start_m = device::tip_position_m(which.device.geometry, which.q_rad);
    const Vector3 end_m = start_m - speed_m_per_s * kLongestApproach_s * Vector3::UnitY();
    const double height_m = start_m.y() - speed_m_per_s * kApproach_s - lower_m;
    simulated::SimulatedPhantom phantom(
        which.device, options_of(which, {{0.0, start_m}, {kLongestApproach_s, end_m}}), start_m);
    WallServo servo(which, phantom.description(), height_m);
    servo.rest_at(phantom.truth().theta_rad);
    device::Measurement state = phantom.advance(device::DeviceCommand::braking());
    const simulated::SimulatedPhantom::Truth &now = phantom.truth();
    double last_m = now.tip_m.y();
    double idle_N = 0.0; // what the motors push in free space, by the filter's lag
    while (now.tip_m.y() >= height_m && now.time_s < kLongestApproach_s) {
        last_m = now.tip_m.y();
        idle_N = motors_push_N(which, phantom);
        state = phantom.advance(servo.command(state.counts));
    }
    const double speed = (last_m - now.tip_m.y()) / which.period_s;
    const double contact_s = now.time_s - (height_m - now.tip_m.y()) / speed;
    Impact seen;
    do {
        state = phantom.advance(servo.command(state.counts));
        const double grown_N = motors_push_N(which, phantom) - idle_N;
        const double since_s = now.time_s - contact_s;
        seen.greatest_force_N = std::max(seen.greatest_force_N, grown_N);
        if (since_s >= kSoonest_s) {
            seen.rate_hardness_N_per_m =
                std::max(seen.rate_hardness_N_per_m, grown_N / (since_s * speed));
        }
    } while (now.time_s < contact_s + kWatched_s);
    return seen;
}

} // namespace

Impact impact(const loops::StabilityCase &which, double speed_m_per_s) {
    constexpr int kPhases = 8;
    Impact mean;
    for (int i = 0; i < kPhases; ++i) {
        const Impact one =
            impact_at(which, speed_m_per_s, (i + 0.5) / kPhases * speed_m_per_s * which.period_s);
        mean.rate_hardness_N_per_m += one.rate_hardness_N_per_m / kPhases;
        mean.greatest_force_N += one.greatest_force_N / kPhases;
    }
    return mean;
}

double apparent_mass_kg(const loops::StabilityCase &which) {
    constexpr double kFrequency_hz = 5.0;
    constexpr double kAmplitude_m = 0.01;
    constexpr int kPeriods = 6; // the first two are not counted
    const double omega = 2.0 * std::numbers::pi * kFrequency_hz;
    const Vector3 start_m = device::tip_position_m(which.device.geometry, which.q_rad);
    std::vector<simulated::HandPath::Point> path;
    constexpr int kPoints = 1200; // a millisecond apart
    path.reserve(kPoints + 1);
    for (int i = 0; i <= kPoints; ++i) {
        const double t = kPeriods / kFrequency_hz * i / kPoints;
        path.push_back({t, start_m + kAmplitude_m * std::sin(omega * t) * Vector3::UnitY()});
    }
    loops::StabilityCase held = which; // a hand that leads firmly, whatever it weighs
    held.hands = {{"leading", 0.0, 30.0, 3000.0}};
    simulated::SimulatedPhantom phantom(which.device, options_of(held, path), start_m);
    WallServo servo(held, phantom.description(), -HUGE_VAL);
    servo.rest_at(phantom.truth().theta_rad);
    device::Measurement state = phantom.advance(device::DeviceCommand::braking());
    // F = m a + b v + c along the vertical, by the parts of force and motion at 5 Hz.
    double force_in = 0.0;
    double force_square = 0.0;
    double way_in = 0.0;
    double way_square = 0.0;
    while (phantom.truth().time_s < kPeriods / kFrequency_hz - 0.5 * which.period_s) {
        state = phantom.advance(servo.command(state.counts));
        const simulated::SimulatedPhantom::Truth &truth = phantom.truth();
        if (truth.time_s > 2.0 / kFrequency_hz + 0.5 * which.period_s) {
            // The force is a mean over the last period: that of its middle.
            const double middle = omega * (truth.time_s - 0.5 * which.period_s);
            force_in += truth.hand_force_N.y() * std::sin(middle);
            force_square += truth.hand_force_N.y() * std::cos(middle);
            way_in += truth.tip_m.y() * std::sin(omega * truth.time_s);
            way_square += truth.tip_m.y() * std::cos(omega * truth.time_s);
        }
    }
    // Of F/x the part in phase is −m ω².
    const double ratio = (force_in * way_in + force_square * way_square) /
                         (way_in * way_in + way_square * way_square);
    return -ratio / (omega * omega);
}

} // namespace springdrive::limits
