#include "engine/lab/limits/drive_comparison.h"

#include "device/core/phantom/kinematics.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/control/rendered_force.h"
#include "engine/lab/limits/stability_simulation.h"
#include "engine/lab/rig/law_rig.h"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>

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

/// A simulated device that is observed many times in each servo period.
class ObservedPlant final : public rig::Plant {
public:
    /// @param phantom  with a period of `which.period_s / steps` and no delay
    ObservedPlant(simulated::SimulatedPhantom &phantom, const loops::StabilityCase &which,
                  int steps, std::function<void()> observe)
        : phantom_(phantom), delay_periods_(which.delay_periods), steps_(steps),
          theta_rad_(phantom.truth().theta_rad), observe_(std::move(observe)) {
        commands_.fill({device::DeviceCommand::braking(), Vector3::Zero()});
    }

    void advance(const simulated::PlantCommand &command) override {
        std::shift_right(commands_.begin(), commands_.end(), 1);
        commands_.front() = command;
        for (int step = 0; step < steps_; ++step) {
            const double to_come = delay_periods_ - static_cast<double>(step) / steps_;
            const auto age = static_cast<std::size_t>(std::ceil(std::max(0.0, to_come)));
            const std::array<std::int32_t, 3> counts = phantom_.advance(commands_.at(age)).counts;
            theta_rad_ =
                phantom_.description().rad_per_count() * Vector3(counts[0], counts[1], counts[2]);
            observe_();
        }
    }

    [[nodiscard]] Vector3 theta_rad() const override { return theta_rad_; }

private:
    simulated::SimulatedPhantom &phantom_;
    double delay_periods_;
    int steps_;
    Vector3 theta_rad_;
    std::function<void()> observe_;
    /// Newest first.
    std::array<simulated::PlantCommand, simulated::SimulationOptions::kMaxDelay + 1> commands_;
};

/// The moment at which the tip reaches the wall.
struct Touchdown {
    double time_s = 0.0;
    double speed_m_per_s = 0.0;
};

/// One impact on a wall `lower_m` below the nominal end of the approach.
Impact impact_at(const loops::StabilityCase &which, double speed_m_per_s, double lower_m) {
    constexpr double kSoonest_s = 0.001;
    constexpr double kWatched_s = 0.01;
    constexpr double kStep_s = 20e-6;
    const loops::Hand hand =
        which.hands.empty() ? loops::hand_of_firmness(0.5) : which.hands.front();
    rig::Scenario scenario = rig::impact_scenario(
        setting_of(which), {simulated_hand(hand), speed_m_per_s, lower_m, which.drive});
    const int steps = std::max(1, static_cast<int>(std::lround(which.period_s / kStep_s)));
    scenario.simulation.servo_period_s = which.period_s / steps;
    scenario.simulation.delay_periods = 0.0;
    simulated::SimulatedPhantom phantom(scenario.device, scenario.simulation, scenario.start_m);
    const simulated::SimulatedPhantom::Truth &now = phantom.truth();

    Impact seen;
    std::optional<Touchdown> touchdown;
    double idle_N = 0.0; // force of the motors in free space, from the filter's lag
    const auto observe = [&] {
        const double force_N = motors_push_N(which, phantom);
        if (!touchdown) {
            const double above_m = now.tip_m.y() - scenario.contact_m.y();
            if (above_m >= 0.0) {
                idle_N = force_N;
                return;
            }
            const double speed = -now.tip_velocity_m_per_s.y();
            touchdown = {now.time_s + above_m / speed, speed};
        }
        const double since_s = now.time_s - touchdown->time_s;
        if (since_s > kWatched_s) {
            return;
        }
        const double grown_N = force_N - idle_N;
        seen.max_force_N = std::max(seen.max_force_N, grown_N);
        if (since_s >= kSoonest_s) {
            seen.rate_hardness_N_per_m = std::max(seen.rate_hardness_N_per_m,
                                                  grown_N / (since_s * touchdown->speed_m_per_s));
        }
    };
    ObservedPlant plant(phantom, which, steps, observe);
    rig::LawRig loop(plant, law_of(which), scenario.constraint, rig::FirstCommand::brakes);
    while (now.time_s < (touchdown ? touchdown->time_s + kWatched_s : scenario.duration_s)) {
        loop.tick();
    }
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
