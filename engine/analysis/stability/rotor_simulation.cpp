#include "engine/analysis/stability/rotor_simulation.h"

#include <algorithm>
#include <cmath>

namespace springdrive {

namespace {

constexpr double kLongestStep_s = 50e-6; // K_L against a bare rotor: (ωh)²/12 = 5e-4

} // namespace

RotorSimulation::RotorSimulation(const RotorSimulationOptions &options)
    : options_(options),
      steps_(std::max(1, static_cast<int>(std::ceil(options.period_s / kLongestStep_s - 1e-9)))),
      h_(options.period_s / steps_), theta_rad_(options.start_rad), before_rad_(measured_rad()),
      held_(static_cast<std::size_t>(options.delay_samples) + 1, 0.0) {}

double RotorSimulation::measured_rad() const {
    const double quantum = options_.quantum_rad;
    return quantum > 0.0 ? quantum * std::round(theta_rad_ / quantum) : theta_rad_;
}

void RotorSimulation::tick() {
    const double now_rad = measured_rad();
    filtered_ = options_.filter_pole * filtered_ +
                (1.0 - options_.filter_pole) / options_.period_s * (now_rad - before_rad_);
    before_rad_ = now_rad;
    std::shift_left(held_.begin(), held_.end(), 1);
    held_.back() = options_.per_velocity * filtered_ + options_.per_position * now_rad;
    for (int i = 0; i < steps_; ++i) {
        advance(held_.front());
    }
}

/// The rate after a sub-step, from
///
///   J (ω₁ − ω₀)/h = k_T ī(ω̄) − b ω̄ − k (θ₀ + h ω̄/2) + friction,   ω̄ = (ω₀ + ω₁)/2
///
/// where friction opposes the motion, or holds, as device/simulated/friction.h has it.
double RotorSimulation::rate_after(const CurrentStep &drive) const {
    const double k_T = options_.motor.torque_constant_Nm_per_A;
    const RotorLoad &load = options_.load;
    const double resists = 0.5 * h_ *
                           (load.damping_Nms_per_rad + 0.5 * h_ * load.stiffness_Nm_per_rad -
                            k_T * drive.mean_As_per_rad);
    const double pushes = (load.inertia_kg_m2 - resists) * rate_ +
                          h_ * (k_T * drive.mean_A - load.stiffness_Nm_per_rad * theta_rad_);
    const double lowest = rate_ < 0.0 ? 0.0 : -h_ * options_.coulomb_Nm;
    const double highest = rate_ > 0.0 ? 0.0 : h_ * options_.coulomb_Nm;
    const double all = load.inertia_kg_m2 + resists;
    if (pushes + lowest > 0.0) {
        return (pushes + lowest) / all;
    }
    return pushes + highest < 0.0 ? (pushes + highest) / all : 0.0;
}

void RotorSimulation::advance(double command) {
    const MotorParameters &motor = options_.motor;
    const DriveState now{motor.resistance_Ohm, current_A_, rate_, options_.amplifier_limits};
    const CurrentStep drive =
        options_.drive == AmplifierKind::spring_drive
            ? spring_drive_step(motor, now, command,
                                motor.resistance_Ohm - options_.net_resistance_Ohm, h_)
            : current_drive_step(motor, now, command, options_.current_bandwidth_rad_per_s, h_);
    const double after = rate_after(drive);
    const double mean = 0.5 * (rate_ + after);
    theta_rad_ += h_ * mean;
    rate_ = after;
    current_A_ = drive.end_at(mean);
}

} // namespace springdrive
