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

namespace springdrive::limits {

namespace {

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

/// One impact on a wall `lower_m` below the nominal end of the approach.
Impact impact_at(const loops::StabilityCase &which, double speed_m_per_s, double lower_m) {
    constexpr double kSoonest_s = 0.001;
    constexpr double kWatched_s = 0.01;
    const loops::Hand hand =
        which.hands.empty() ? loops::hand_of_firmness(0.5) : which.hands.front();
    const rig::Scenario scenario = rig::impact_scenario(
        setting_of(which), {simulated_hand(hand), speed_m_per_s, lower_m, which.drive});
    const double height_m = scenario.contact_m.y();
    simulated::SimulatedPhantom phantom(scenario.device, scenario.simulation, scenario.start_m);
    rig::PhantomPlant plant(phantom);
    rig::LawRig loop(plant, law_of(which), scenario.constraint, rig::FirstCommand::brakes);
    loop.tick();
    const simulated::SimulatedPhantom::Truth &now = phantom.truth();
    double last_m = now.tip_m.y();
    double idle_N = 0.0; // force of the motors in free space, from the filter's lag
    while (now.tip_m.y() >= height_m && now.time_s < scenario.duration_s) {
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
        seen.max_force_N = std::max(seen.max_force_N, grown_N);
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
        mean.max_force_N += one.max_force_N / kPhases;
    }
    return mean;
}

double apparent_mass_kg(const loops::StabilityCase &which) {
    constexpr double kFrequency_Hz = rig::StrokeOptions::kFrequency_Hz;
    const double omega = 2.0 * std::numbers::pi * kFrequency_Hz;
    const rig::Scenario scenario = rig::stroke_scenario(setting_of(which), {which.drive});
    simulated::SimulatedPhantom phantom(scenario.device, scenario.simulation, scenario.start_m);
    rig::PhantomPlant plant(phantom);
    rig::LawRig loop(plant, law_of(which), scenario.constraint, rig::FirstCommand::brakes);
    loop.tick();
    // F = m a + b v + c along the vertical, from the components of force and motion at 5 Hz.
    double force_sine = 0.0;
    double force_cosine = 0.0;
    double tip_sine = 0.0;
    double tip_cosine = 0.0;
    while (phantom.truth().time_s < scenario.duration_s - 0.5 * which.period_s) {
        loop.tick();
        const simulated::SimulatedPhantom::Truth &truth = phantom.truth();
        if (truth.time_s >
            rig::StrokeOptions::kPeriodsBefore / kFrequency_Hz + 0.5 * which.period_s) {
            // The force is a mean over the last period, so it belongs to the period's middle.
            const double middle = omega * (truth.time_s - 0.5 * which.period_s);
            force_sine += truth.hand_force_N.y() * std::sin(middle);
            force_cosine += truth.hand_force_N.y() * std::cos(middle);
            tip_sine += truth.tip_m.y() * std::sin(omega * truth.time_s);
            tip_cosine += truth.tip_m.y() * std::cos(omega * truth.time_s);
        }
    }
    // The component of F/x in phase is −m ω².
    const double ratio = (force_sine * tip_sine + force_cosine * tip_cosine) /
                         (tip_sine * tip_sine + tip_cosine * tip_cosine);
    return -ratio / (omega * omega);
}

} // namespace springdrive::limits
