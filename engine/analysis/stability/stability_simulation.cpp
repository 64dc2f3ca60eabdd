#include "engine/analysis/stability/stability_simulation.h"

#include "device/phantom/kinematics.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/analysis/stability/rotor_simulation.h"
#include "engine/control/haptic_law.h"
#include "engine/control/velocity_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace springdrive {

namespace {

/// @param start_rad  how far motors are from rest at first, about
RingdownOptions ringdown_options(const TrialOptions &options, double start_rad) {
    // Modes lie below 1e4 rad/s, or little above. Without a supply that ends, the linkage would
    // else find a bound of its own, whirling round, before growth is seen.
    constexpr double kGreatestRate_per_s = 1e7;
    RingdownOptions how;
    how.longest_s = options.longest_s;
    how.greatest = kGreatestRate_per_s * start_rad;
    // Encoders keep small motions up at a steady size, whose measured slope is near zero.
    how.least_decay_per_s = options.effects.quantisation ? 0.2 : 0.0;
    return how;
}

/// How far angles go to and fro.
class Span {
public:
    void add(const Vector3 &theta_rad) {
        least_ = least_.cwiseMin(theta_rad);
        greatest_ = greatest_.cwiseMax(theta_rad);
    }
    [[nodiscard]] double greatest_rad() const { return (greatest_ - least_).maxCoeff(); }

private:
    Vector3 least_ = Vector3::Constant(HUGE_VAL);
    Vector3 greatest_ = Vector3::Constant(-HUGE_VAL);
};

/// The flicker of the last counts, however fast: not a motion that a loop makes.
/// @param tick  moves on by a period and returns the true angles
template <typename Tick> bool only_flickers(double count_rad, double period_s, const Tick &tick) {
    constexpr double kCounts = 2.0;
    constexpr double kWatched_s = 0.2;
    Span span;
    constexpr double kLeastTicks = 20.0; // one alone would never move
    const long ticks = std::lround(std::max(kLeastTicks, std::ceil(kWatched_s / period_s)));
    for (long i = 0; i < ticks; ++i) {
        span.add(tick());
    }
    return span.greatest_rad() <= kCounts * count_rad;
}

Trial outcome(const Ringdown &ringdown) {
    return {ringdown.dies_out(), ringdown.growth_per_s(), ringdown.last()};
}

RotorSimulationOptions rotor_options(const StabilityCase &which, const LoopMember &member,
                                     const TrialOptions &options) {
    const DrivenLoad load = driven_load(which, member);
    const SampledLaw law = sampled_law(which, member);
    RotorSimulationOptions rotor;
    rotor.motor = which.device.motor[static_cast<std::size_t>(member.motor)];
    rotor.drive = which.drive;
    rotor.current_bandwidth_rad_per_s =
        2.0 * std::numbers::pi * which.device.amplifier.current_bandwidth_hz;
    rotor.net_resistance_Ohm = which.dR_Ohm(rotor.motor);
    rotor.load = {load.inertia_kg_m2(0, 0), load.damping_Nms_per_rad(0, 0),
                  load.stiffness_Nm_per_rad(0, 0)};
    rotor.period_s = which.period_s;
    rotor.delay_samples = which.delay_samples;
    rotor.filter_pole = law.filter_pole;
    rotor.per_velocity = law.per_velocity(0, 0);
    rotor.per_position = law.per_position(0, 0);
    rotor.quantum_rad = options.effects.quantisation ? which.device.rad_per_count() : 0.0;
    rotor.amplifier_limits = options.effects.saturation;
    const double N = which.device.geometry.transmission_ratio[member.motor];
    rotor.coulomb_Nm =
        options.effects.friction ? which.device.friction.coulomb_Nm[member.motor] / N : 0.0;
    const Matrix3 J = motor_jacobian(which.device.geometry, which.q_rad);
    rotor.start_rad = options.start_m / J.col(member.motor).norm();
    return rotor;
}

/// Windows that hold half a period of what command and load make of the rotor at low frequency.
RingdownOptions for_slow_ones(RingdownOptions ringdown, const RotorSimulationOptions &rotor) {
    constexpr double kLongestWindow_s = 1.0;
    constexpr double kWindows = 10.0;
    const double torque_per_command =
        rotor.motor.torque_constant_Nm_per_A /
        (rotor.drive == AmplifierKind::spring_drive ? rotor.net_resistance_Ohm : 1.0);
    const double stiffness_Nm_per_rad =
        rotor.load.stiffness_Nm_per_rad - torque_per_command * rotor.per_position;
    if (stiffness_Nm_per_rad > 0.0) {
        const double half_period_s =
            std::numbers::pi * std::sqrt(rotor.load.inertia_kg_m2 / stiffness_Nm_per_rad);
        ringdown.window_s = std::clamp(half_period_s, ringdown.window_s, kLongestWindow_s);
        ringdown.longest_s = std::max(ringdown.longest_s, kWindows * ringdown.window_s);
    }
    return ringdown;
}

Trial one_motor_trial(const StabilityCase &which, const LoopMember &member,
                      const TrialOptions &options) {
    const RotorSimulationOptions how = rotor_options(which, member, options);
    RotorSimulation rotor(how);
    Ringdown ringdown(for_slow_ones(ringdown_options(options, how.start_rad), how), which.period_s);
    do {
        rotor.tick();
    } while (ringdown.watch(std::abs(rotor.rate_rad_per_s())));
    Trial trial = outcome(ringdown);
    trial.stable = trial.stable || only_flickers(how.quantum_rad, which.period_s, [&] {
                       rotor.tick();
                       return Vector3(rotor.theta_rad(), 0.0, 0.0);
                   });
    return trial;
}

/// The whole law, or the wall of a current drive, for a tip that is tied to a point.
class TiedTip {
public:
    TiedTip(const StabilityCase &which, const DeviceDescription &device, const Vector3 &point_m)
        : which_(which), law_(device), global_alpha_(global_alpha_bound(which.device)) {
        tie_.touching = true;
        tie_.x0_m = point_m;
        tie_.allowed_motion.setZero();
        tie_.eta = 0.0;
    }

    [[nodiscard]] DeviceCommand command(const Vector3 &theta_rad) {
        const double pole = velocity_filter_pole(which_.tuning.lambda_rad_per_s, which_.period_s);
        const Vector3 rate = filter_.update(theta_rad, pole, which_.period_s);
        const Configuration now = law_.configuration(theta_rad, rate);
        if (which_.drive == AmplifierKind::current_drive) {
            return current_command(now);
        }
        DeviceCommand command = law_(now, tie_, which_.tuning, global_alpha_).command;
        for (Eigen::Index j = 0; j < 3; ++j) {
            const MotorParameters &motor = which_.device.motor[static_cast<std::size_t>(j)];
            command.cancelled_resistance_Ohm[j] = motor.resistance_Ohm - which_.dR_Ohm(motor);
        }
        return command;
    }

    void rest_at(const Vector3 &theta_rad) { filter_.reset(theta_rad); }

private:
    [[nodiscard]] DeviceCommand current_command(const Configuration &now) const {
        const Vector3 force_N =
            (1.0 - which_.tuning.eta) * (which_.wall.stiffness_N_per_m * (tie_.x0_m - now.tip_m) -
                                         which_.wall.damping_Ns_per_m * now.tip_velocity_m_per_s());
        DeviceCommand command;
        command.current_A = Vector3(now.J.transpose() * force_N).cwiseQuotient(law_.k_T());
        return command;
    }

    const StabilityCase &which_;
    HapticLaw law_;
    double global_alpha_;
    VelocityFilter filter_;
    Contact tie_;
};

SimulationOptions phantom_options(const StabilityCase &which, const LoopMember &member,
                                  const TrialOptions &options) {
    SimulationOptions simulation;
    simulation.servo_period_s = which.period_s;
    simulation.delay_samples = which.delay_samples;
    simulation.quantised_encoders = options.effects.quantisation;
    simulation.hand = {member.hand.mass_kg, member.hand.damping_Ns_per_m,
                       member.hand.stiffness_N_per_m, HUGE_VAL, 1.0};
    simulation.effects = PlantEffects::none();
    simulation.effects.viscous_friction = true;
    simulation.effects.coulomb_friction = options.effects.friction;
    simulation.effects.amplifier_limits = options.effects.saturation;
    simulation.amplifier = which.drive;
    return simulation;
}

Trial three_motor_trial(const StabilityCase &which, const LoopMember &member,
                        const TrialOptions &options) {
    const PhantomGeometry &geometry = which.device.geometry;
    const Vector3 rest_m = tip_position_m(geometry, which.q_rad);
    // Let go beside rest in a direction that no mode is square to.
    const Vector3 aside = options.start_m * Vector3(0.6, 0.64, 0.48);
    DeviceDescription device = which.device;
    device.amplifier.greatest_cancelled_Ohm = HUGE_VAL; // over-cancelled as far as is asked for
    SimulatedPhantom phantom(device, phantom_options(which, member, options), rest_m);
    TiedTip tip(which, phantom.description(), rest_m + aside);
    Vector3 theta_rad = phantom.truth().theta_rad;
    tip.rest_at(theta_rad);
    const double per_count = phantom.description().rad_per_count();
    const double start_rad = options.start_m / motor_jacobian(geometry, which.q_rad).norm();
    Ringdown ringdown(ringdown_options(options, start_rad), which.period_s);
    const auto tick = [&]() -> const Vector3 & {
        const DeviceState state = phantom.exchange(tip.command(theta_rad));
        theta_rad = per_count * Vector3(state.counts[0], state.counts[1], state.counts[2]);
        return phantom.truth().theta_rad;
    };
    do {
        tick();
    } while (ringdown.watch(phantom.truth().theta_rate_rad_per_s.cwiseAbs().maxCoeff()));
    Trial trial = outcome(ringdown);
    trial.stable = trial.stable || only_flickers(per_count, which.period_s, tick);
    return trial;
}

} // namespace

Trial simulated(const StabilityCase &which, const LoopMember &member, const TrialOptions &options) {
    return which.freedom == Freedom::one_motor ? one_motor_trial(which, member, options)
                                               : three_motor_trial(which, member, options);
}

bool is_stable_simulated(const StabilityCase &which, const TrialOptions &options) {
    const std::vector<LoopMember> all = members(which);
    return std::all_of(all.begin(), all.end(), [&](const LoopMember &member) {
        return simulated(which, member, options).stable;
    });
}

} // namespace springdrive
