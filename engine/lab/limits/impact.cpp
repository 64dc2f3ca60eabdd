#include "engine/lab/limits/impact.h"

#include "device/core/phantom/kinematics.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/control/force_direction.h"
#include "engine/lab/limits/stability_simulation.h"
#include "engine/lab/rig/law_rig.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace springdrive::limits {

namespace {

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
    rig::PhantomPlant plant(phantom);
    const Vector3 wall_m(start_m.x(), height_m, start_m.z());
    rig::LawRig loop(plant, law_of(which), rig::plane(wall_m, Vector3::UnitY(), rig::Sides::one),
                     rig::FirstCommand::brakes);
    loop.tick();
    const simulated::SimulatedPhantom::Truth &now = phantom.truth();
    double last_m = now.tip_m.y();
    double idle_N = 0.0; // what the motors push in free space, by the filter's lag
    while (now.tip_m.y() >= height_m && now.time_s < kLongestApproach_s) {
        last_m = now.tip_m.y();
        idle_N = motors_push_N(which, phantom);
        loop.tick();
    }
    const double speed = (last_m - now.tip_m.y()) / which.period_s;
    const double contact_s = now.time_s - (height_m - now.tip_m.y()) / speed;
    Impact seen;
    do {
        loop.tick();
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
    rig::PhantomPlant plant(phantom);
    rig::LawRig loop(plant, law_of(held), rig::free_space(), rig::FirstCommand::brakes);
    loop.tick();
    // F = m a + b v + c along the vertical, by the parts of force and motion at 5 Hz.
    double force_in = 0.0;
    double force_square = 0.0;
    double way_in = 0.0;
    double way_square = 0.0;
    while (phantom.truth().time_s < kPeriods / kFrequency_hz - 0.5 * which.period_s) {
        loop.tick();
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
