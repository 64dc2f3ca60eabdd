#include "engine/lab/limits/stability_simulation.h"

#include "device/core/phantom/kinematics.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/lab/rig/rotor_simulation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace springdrive::limits {

namespace {

/// @param start_rad  approximate initial distance of the motors from rest
rig::RingdownOptions ringdown_options(const TrialOptions &options, double start_rad) {
    // Modes lie below 1e4 rad/s or little above. Without supply limits the linkage would otherwise
    // saturate by whirling round before growth is detected.
    constexpr double kMaxRate_per_s = 1e7;
    rig::RingdownOptions how;
    how.longest_s = options.longest_s;
    how.extension_s = options.extension_s;
    how.maximum = kMaxRate_per_s * start_rad;
    // Encoders can sustain small motions of constant amplitude, whose measured slope is near zero.
    how.min_decay_per_s = options.effects.quantisation ? 0.2 : 0.0;
    return how;
}

/// Half a period of the slowest oscillation of load and command at low frequency; zero without one.
double slowest_half_period_s(const loops::DrivenLoad &load, const loops::SampledLaw &law) {
    const Eigen::VectorXd squares = loops::static_squares(load, law);
    constexpr double kFree = 1e-9; // of the stiffest: round-off of an unconstrained direction
    double minimum = HUGE_VAL;
    for (const double square : squares) {
        minimum =
            square > kFree * squares.cwiseAbs().maxCoeff() ? std::min(minimum, square) : minimum;
    }
    return std::numbers::pi / std::sqrt(minimum);
}

/// How a member's motion is observed.
struct Watch {
    rig::RingdownOptions ringdown;
    double chatter_s = 0.0; ///< how long a mere flicker must last to count as rest
};

/// @param start_rad  approximate initial distance of the motors from rest
Watch how_to_watch(const loops::StabilityCase &which, const loops::LoopMember &member,
                   const TrialOptions &options, double start_rad) {
    const double half_period_s =
        slowest_half_period_s(loops::driven_load(which, member), loops::sampled_law(which, member));
    Watch watch{ringdown_options(options, start_rad), 0.0};
    constexpr double kMaxWindow_s = 1.0;
    constexpr double kWindows = 10.0;
    rig::RingdownOptions &ringdown = watch.ringdown;
    ringdown.window_s = std::max(ringdown.window_s, std::min(half_period_s, kMaxWindow_s));
    if (half_period_s > 0.0) {
        ringdown.longest_s = std::max(ringdown.longest_s, kWindows * ringdown.window_s);
    }
    // Longer than the turning point of a slow motion, and than the delay before it begins.
    constexpr double kLasting_s = 0.4;
    constexpr double kSamples = 20.0;
    watch.chatter_s = std::max(
        {kLasting_s, 2.0 * ringdown.window_s, (which.delay_periods + kSamples) * which.period_s});
    return watch;
}

/// The observed motion at a sample.
struct Motion {
    Vector3 theta_rad;
    double rate_rad_per_s = 0.0; ///< the largest of all motors
};

/// @param count_rad  of an encoder; 0 without quantisation
/// @param tick  advances by a period and returns the true motion
template <typename Tick>
Trial watched(const Watch &watch, double count_rad, double period_s, const Tick &tick) {
    constexpr double kCounts = 2.0;
    rig::QuantisationChatter chatter(kCounts * count_rad, watch.chatter_s, period_s);
    rig::Ringdown ringdown(watch.ringdown, period_s);
    for (bool more = true; more && !chatter.is_all();) {
        const Motion motion = tick();
        chatter.watch(motion.theta_rad);
        more = ringdown.watch(motion.rate_rad_per_s);
    }
    const bool dies_out = ringdown.dies_out();
    while (!dies_out && chatter.may_be_all() && !chatter.is_all()) { // rest may just have begun
        chatter.watch(tick().theta_rad);
    }
    return {dies_out || chatter.is_all(), ringdown.stays(), ringdown.growth_per_s(),
            ringdown.last()};
}

rig::RotorSimulationOptions rotor_options(const loops::StabilityCase &which,
                                          const loops::LoopMember &member,
                                          const TrialOptions &options) {
    const loops::DrivenLoad load = loops::driven_load(which, member);
    const loops::SampledLaw law = loops::sampled_law(which, member);
    rig::RotorSimulationOptions rotor;
    rotor.motor = which.device.motor[static_cast<std::size_t>(member.motor)];
    rotor.drive = which.drive;
    rotor.current_bandwidth_rad_per_s =
        2.0 * std::numbers::pi * which.device.amplifier.current_bandwidth_hz;
    rotor.net_resistance_Ohm = which.dR_Ohm(rotor.motor);
    rotor.load = {load.inertia_kg_m2(0, 0), load.damping_Nms_per_rad(0, 0),
                  load.stiffness_Nm_per_rad(0, 0)};
    rotor.period_s = which.period_s;
    rotor.delay_periods = which.delay_periods;
    rotor.filter_pole = law.filter_pole;
    rotor.per_velocity = law.per_velocity(0, 0);
    rotor.per_position = law.per_position(0, 0);
    rotor.quantum_rad = options.effects.quantisation ? which.device.rad_per_count() : 0.0;
    rotor.amplifier_limits = options.effects.saturation;
    const double N = which.device.geometry.transmission_ratio[member.motor];
    rotor.coulomb_Nm =
        options.effects.friction ? which.device.friction.coulomb_Nm[member.motor] / N : 0.0;
    const Matrix3 J = device::motor_jacobian(which.device.geometry, which.q_rad);
    rotor.start_rad = options.start_m / J.col(member.motor).norm();
    return rotor;
}

Trial one_motor_trial(const loops::StabilityCase &which, const loops::LoopMember &member,
                      const TrialOptions &options) {
    const rig::RotorSimulationOptions how = rotor_options(which, member, options);
    rig::RotorSimulation rotor(how);
    const Watch watch = how_to_watch(which, member, options, how.start_rad);
    return watched(watch, how.quantum_rad, which.period_s, [&rotor] {
        rotor.tick();
        return Motion{Vector3(rotor.theta_rad(), 0.0, 0.0), std::abs(rotor.rate_rad_per_s())};
    });
}

Trial three_motor_trial(const loops::StabilityCase &which, const loops::LoopMember &member,
                        const TrialOptions &options) {
    const device::PhantomGeometry &geometry = which.device.geometry;
    rig::TiedOptions tied;
    tied.hand = simulated_hand(member.hand);
    tied.aside_m = options.start_m;
    tied.quantisation = options.effects.quantisation;
    tied.coulomb_friction = options.effects.friction;
    tied.amplifier_limits = options.effects.saturation;
    tied.drive = which.drive;
    rig::Scenario scenario = rig::tied_scenario(setting_of(which), tied);
    simulated::PlantEffects &effects = scenario.simulation.effects;
    const double tip_kg = member.hand.mass_kg + which.device.inertia.tip_load_kg;
    effects.cable_compliance = member.structure.in_cable() > 0.0;
    effects.structural_compliance = member.structure.at_tip() > 0.0 && tip_kg > 0.0;
    scenario.device.structure.cable_share = member.structure.in_cable();
    if (effects.cable_compliance && !effects.structural_compliance) {
        // Of the plant's effects, one alone has all of the compliance.
        scenario.device.structure.stiffness_N_per_m /= member.structure.in_cable();
    }
    simulated::SimulatedPhantom phantom(scenario.device, scenario.simulation, scenario.start_m);
    rig::PhantomPlant plant(phantom, options.effects.quantisation);
    rig::LawRig loop(plant, law_of(which), scenario.constraint, rig::FirstCommand::answers);
    const double per_count =
        options.effects.quantisation ? phantom.description().rad_per_count() : 0.0;
    const double start_rad = options.start_m / device::motor_jacobian(geometry, which.q_rad).norm();
    const Watch watch = how_to_watch(which, member, options, start_rad);
    return watched(watch, per_count, which.period_s, [&] {
        loop.tick();
        const simulated::SimulatedPhantom::Truth &truth = phantom.truth();
        return Motion{truth.theta_rad, truth.theta_rate_rad_per_s.cwiseAbs().maxCoeff()};
    });
}

} // namespace

rig::LawOptions law_of(const loops::StabilityCase &which) {
    rig::LawOptions options;
    options.device = which.device;
    options.tuning = which.tuning;
    options.period_s = which.period_s;
    options.net_resistance_Ohm = which.net_resistance_Ohm;
    options.drive = which.drive;
    options.wall = which.wall;
    return options;
}

rig::ScenarioSetting setting_of(const loops::StabilityCase &which) {
    return {which.device, which.tuning, which.q_rad, which.period_s, which.delay_periods};
}

device::HandParameters simulated_hand(const loops::Hand &hand, double max_force_N) {
    constexpr double kMaxSpeed_m_per_s = 1.0;
    return {hand.mass_kg, hand.damping_Ns_per_m, hand.stiffness_N_per_m, max_force_N,
            kMaxSpeed_m_per_s};
}

Trial simulated(const loops::StabilityCase &which, const loops::LoopMember &member,
                const TrialOptions &options) {
    return which.freedom == loops::Freedom::one_motor
               ? one_motor_trial(which, {member.motor, member.hand}, options)
               : three_motor_trial(which, member, options);
}

loops::StabilityCase as_tried(const loops::StabilityCase &which) {
    loops::StabilityCase tried = which;
    if (which.freedom == loops::Freedom::one_motor) {
        tried.structures = {loops::Structure{}};
    }
    return tried;
}

bool is_stable_simulated(const loops::StabilityCase &which, const TrialOptions &options) {
    const std::vector<loops::LoopMember> all = loops::members(as_tried(which));
    return std::all_of(all.begin(), all.end(), [&](const loops::LoopMember &member) {
        return simulated(which, member, options).stable;
    });
}

} // namespace springdrive::limits
