#include "engine/lab/rig/rotor_simulation.h"

#include "device/core/split_delay.h"

#include <algorithm>
#include <cmath>

namespace springdrive::rig {

namespace {

constexpr double kMaxStep_s = 50e-6; // K_L against a bare rotor: (ωh)²/12 = 5e-4

/// The number of sub-steps of a time.
int steps_of(double time_s) {
    return std::max(1, static_cast<int>(std::ceil(time_s / kMaxStep_s - 1e-9)));
}

} // namespace

RotorSimulation::RotorSimulation(const RotorSimulationOptions &options)
    : options_(options), theta_rad_(options.start_rad), before_rad_(measured_rad()) {
    const device::SplitDelay delay = device::split_delay(options.delay_periods);
    const auto part = [](double time_s) {
        return Part{steps_of(time_s), time_s / steps_of(time_s)};
    };
    if (delay.fraction > 0.0) {
        first_ = part(delay.fraction * options.period_s);
    }
    second_ = part((1.0 - delay.fraction) * options.period_s);
    held_.assign(static_cast<std::size_t>(delay.whole) + 2, 0.0);
}

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
    advance(held_[0], first_);
    advance(held_[1], second_);
}

/// The rate after a sub-step, from
///
///   J (ω₁ − ω₀)/h = k_T ī(ω̄) − b ω̄ − k (θ₀ + h ω̄/2) + friction,   ω̄ = (ω₀ + ω₁)/2
///
/// where friction opposes the motion, or holds, as device/simulated/friction.h has it.
double RotorSimulation::rate_after(const device::CurrentStep &drive, double h_s) const {
    const double k_T = options_.motor.torque_constant_Nm_per_A;
    const device::RotorLoad &load = options_.load;
    const double resists = 0.5 * h_s *
                           (load.damping_Nms_per_rad + 0.5 * h_s * load.stiffness_Nm_per_rad -
                            k_T * drive.mean_As_per_rad);
    const double pushes = (load.inertia_kg_m2 - resists) * rate_ +
                          h_s * (k_T * drive.mean_A - load.stiffness_Nm_per_rad * theta_rad_);
    const double minimum = rate_ < 0.0 ? 0.0 : -h_s * options_.coulomb_Nm;
    const double maximum = rate_ > 0.0 ? 0.0 : h_s * options_.coulomb_Nm;
    const double all = load.inertia_kg_m2 + resists;
    if (pushes + minimum > 0.0) {
        return (pushes + minimum) / all;
    }
    return pushes + maximum < 0.0 ? (pushes + maximum) / all : 0.0;
}

void RotorSimulation::advance(double command, const Part &part) {
    for (int i = 0; i < part.steps; ++i) {
        advance(command, part.h_s);
    }
}

void RotorSimulation::advance(double command, double h_s) {
    const device::MotorParameters &motor = options_.motor;
    const device::DriveState now{motor.resistance_Ohm, current_A_, rate_,
                                 options_.amplifier_limits};
    const device::CurrentStep drive =
        options_.drive == device::AmplifierKind::spring_drive
            ? device::spring_drive_step(motor, now, command,
                                        motor.resistance_Ohm - options_.net_resistance_Ohm, h_s)
            : device::current_drive_step(motor, now, command, options_.current_bandwidth_rad_per_s,
                                         h_s);
    const double after = rate_after(drive, h_s);
    const double mean = 0.5 * (rate_ + after);
    theta_rad_ += h_s * mean;
    rate_ = after;
    current_A_ = drive.end_at(mean);
}

} // namespace springdrive::rig
