#include "device/simulated/plant_setup.h"

#include "base/input_error.h"
#include "base/split_mix.h"
#include "device/core/phantom/kinematics.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <string>

namespace springdrive::simulated {

namespace {

/// Uniform in [-1, 1], the same on every machine: the standard's distributions are not.
[[nodiscard]] double either_way(std::mt19937_64 &random) {
    return 2.0 * split_mix::unit_share(random()) - 1.0;
}

/// Its logarithm is uniform between theirs; zero where they are.
[[nodiscard]] double draw_scale(double min, double max, std::mt19937_64 &random) {
    const double exponent = 0.5 * (1.0 + either_way(random));
    return max > 0.0 ? min * std::pow(max / min, exponent) : 0.0;
}

[[nodiscard]] SensorError draw_sensor(const device::CurrentSensing &sensing,
                                      std::mt19937_64 &random) {
    SensorError error;
    error.gain = 1.0 + sensing.gain_tolerance * either_way(random);
    error.offset_A = sensing.max_offset_A * either_way(random);
    return error;
}

/// Rejects options that a plant without masses cannot have.
void check_coupling(const SimulationOptions &options) {
    if (options.dynamics != PlantDynamics::coupling) {
        return;
    }
    if (options.effects.coulomb_friction || options.effects.structural_compliance ||
        options.effects.cable_compliance) {
        throw InputError("simulated device: with dynamics 'coupling' it has no masses, so it can "
                         "have none of coulomb_friction, structural_compliance and "
                         "cable_compliance; switch them off or choose other dynamics");
    }
    if (options.amplifier == device::AmplifierKind::current_drive &&
        !(options.hand.stiffness_N_per_m + options.hand.damping_Ns_per_m > 0.0)) {
        throw InputError("simulated device: with dynamics 'coupling' and a current drive only "
                         "the hand holds its tip; give the hand a stiffness or a damping above 0");
    }
}

/// The cables' share of the simulated compliance: all of it if only they are compliant.
double simulated_cable_share(const PlantEffects &effects, const SampledDevice &own) {
    if (!effects.cable_compliance) {
        return 0.0;
    }
    return effects.structural_compliance ? own.cable_share : 1.0;
}

/// The longest sub-step for rotors that swing between their cables and windings (4): h ω ≤ 1/4 with
/// ω² = (κ + k_T²/L)/J_m, where the midpoint rule errs by (h ω)²/12 = 0.5 % of the frequency. On
/// the PHANTOM 1.0 that shortens the default where the cables' share is below 0.13. Below
/// the floor, where cables have less than 0.4 % of the compliance, they are as good as rigid; they
/// remain stable and exact in energy.
double longest_step_s(const std::array<device::CableCompliance, 3> &cables,
                      const std::array<device::MotorParameters, 3> &motors) {
    constexpr double kTurn = 0.25;
    constexpr double kFloor_s = 20e-6;
    double longest_s = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < cables.size(); ++j) {
        const double winding_Nm_per_rad =
            motors[j].inductance_H > 0.0 ? device::inductive_stiffness_Nm_per_rad(motors[j]) : 0.0;
        longest_s = std::min(
            longest_s, kTurn * std::sqrt(motors[j].rotor_inertia_kg_m2 /
                                         (cables[j].stiffness_Nm_per_rad + winding_Nm_per_rad)));
    }
    return std::max(longest_s, kFloor_s);
}

/// Linkage and rotors, with the enabled effects and the load, as far as they are rigidly connected.
/// @param has_cables  between rotors and linkage
/// @param has_free_tip  with the load, behind a compliant structure
LinkagePlant linkage_plant(const device::DeviceDescription &description,
                           const SimulationOptions &options, bool has_cables, bool has_free_tip) {
    const double at_tip_kg = description.inertia.tip_load_kg + options.hand.mass_kg;
    LinkagePlant plant;
    plant.geometry = description.geometry;
    plant.moments = device::linkage_moments(description.geometry, description.inertia,
                                            has_free_tip ? 0.0 : at_tip_kg);
    if (!has_free_tip) {
        // The person holds the hand up: its mass adds inertia, but no weight.
        plant.moments.ma_kg_m -= options.hand.mass_kg * description.geometry.upper_arm_m;
        plant.moments.mb_kg_m -= options.hand.mass_kg * description.geometry.forearm_m;
    }
    for (Eigen::Index j = 0; j < 3 && !has_cables; ++j) {
        const double N = description.geometry.transmission_ratio[j];
        plant.rotor_kg_m2[j] =
            N * N * description.motor[static_cast<std::size_t>(j)].rotor_inertia_kg_m2;
    }
    if (options.effects.coulomb_friction) {
        plant.coulomb_Nm = description.friction.coulomb_Nm;
    }
    plant.limits = description.joint_limits;
    plant.gravity = options.effects.gravity;
    plant.stops = options.effects.joint_limits;
    plant.has_mass = options.dynamics != PlantDynamics::coupling;
    plant.planar = options.planar;
    return plant;
}

/// The deviations of the options' seed, ideal where they are switched off.
SampledDevice simulated_deviations(const device::DeviceDescription &description,
                                   const SimulationOptions &options) {
    const PlantEffects &effects = options.effects;
    SampledDevice device = sampled_device(description, options.device_seed);
    for (SampledMotor &own : device.motor) {
        if (!effects.motor_tolerances) {
            own.resistance_share = 1.0;
            own.torque_constant_share = 1.0;
            own.winding_housing_share = 1.0;
            own.ripples_per_segment = 1;
            own.second_harmonic_ratio = 0.0;
        }
        if (!effects.commutator_phase) {
            own.commutator_phase_rad = 0.0;
            own.second_harmonic_phase_rad = 0.0;
            own.torque_ripple_phase_rad = 0.0;
        }
        if (!effects.current_sensing) {
            own.sensing = {};
        }
        if (!effects.brush_voltage) {
            own.brush_voltage_V = 0.0;
        }
        if (options.brush_voltage_V) {
            own.brush_voltage_V = *options.brush_voltage_V;
            own.brush_current_A = options.brush_current_A;
            own.carried_brush_current_A = options.brush_current_A;
        }
        own.torque_ripple *= effects.torque_ripple ? 1.0 : 0.0;
    }
    return device;
}

/// The true motor parameters.
std::array<device::MotorParameters, 3> true_motors(const device::DeviceDescription &description,
                                                   const SimulationOptions &options,
                                                   const SampledDevice &device) {
    std::array<device::MotorParameters, 3> motors = description.motor;
    for (std::size_t j = 0; j < motors.size(); ++j) {
        const SampledMotor &own = device.motor[j];
        device::MotorParameters &motor = motors[j];
        motor.resistance_Ohm *=
            options.resistance_share[static_cast<Eigen::Index>(j)] * own.resistance_share;
        motor.torque_constant_Nm_per_A *= own.torque_constant_share;
        motor.torque_constant_fall_per_K *= options.effects.magnet_heat ? 1.0 : 0.0;
        motor.commutator_phase_rad = own.commutator_phase_rad;
        motor.commutator_segments *= own.ripples_per_segment;
        motor.commutation_ripple *= options.effects.commutation_ripple ? 1.0 : 0.0;
        motor.commutation_ripple /= 1.0 + own.second_harmonic_ratio;
        motor.second_harmonic = own.second_harmonic_ratio * motor.commutation_ripple;
        motor.second_harmonic_phase_rad = own.second_harmonic_phase_rad;
        // The copper that R_wh leads heat away from stays the same.
        motor.thermal.winding_housing_K_per_W *= own.winding_housing_share;
        motor.thermal.winding_time_s *= own.winding_housing_share;
        if (options.dynamics != PlantDynamics::electromechanical) {
            motor.inductance_H = 0.0; // stores no energy
        }
    }
    return motors;
}

/// Initial temperatures of winding and housing.
device::WindingTemperature temperature(const device::MotorParameters &motor,
                                       const SimulationOptions &options) {
    return {motor.thermal,
            options.effects.winding_heat ? options.ambient_C : device::kReferenceTemperature_C,
            options.servo_period_s};
}

} // namespace

SampledDevice sampled_device(const device::DeviceDescription &description, std::uint64_t seed) {
    SampledDevice drawn;
    drawn.cable_share = description.structure.cable_share.value_or(drawn.cable_share);
    if (seed == 0) {
        return drawn;
    }
    std::mt19937_64 random(seed);
    const device::CurrentSensing &sensing = description.current_sensing;
    for (std::size_t j = 0; j < drawn.motor.size(); ++j) {
        const device::MotorParameters &motor = description.motor[j];
        SampledMotor &own = drawn.motor[j];
        own.resistance_share = 1.0 + motor.resistance_tolerance * either_way(random);
        own.torque_constant_share = 1.0 + motor.torque_constant_tolerance * either_way(random);
        own.commutator_phase_rad = std::numbers::pi * either_way(random);
        own.sensing.converter = draw_sensor(sensing, random);
        const SensorError separate = draw_sensor(sensing, random);
        own.sensing.amplifier = sensing.is_shared ? own.sensing.converter : separate;
        own.sensing.resolution_A = sensing.resolution_A;
        own.sensing.noise_A = sensing.noise_A;
    }
    const bool commutates_twice = either_way(random) > 0.0;
    for (std::size_t j = 0; j < drawn.motor.size(); ++j) {
        const device::MotorParameters &motor = description.motor[j];
        SampledMotor &own = drawn.motor[j];
        const double max_V = motor.max_brush_voltage_V;
        own.brush_voltage_V = draw_scale(0.02 * max_V, max_V, random);
        own.brush_current_A = draw_scale(0.01, 0.2, random);
        own.carried_brush_current_A = draw_scale(0.01, 0.2, random);
        own.brush_film_s = draw_scale(2.0, 60.0, random);
        own.winding_housing_share =
            draw_scale(1.0 / device::kMaxHeatPathFactor, device::kMaxHeatPathFactor, random);
        own.ripples_per_segment = commutates_twice && motor.commutator_segments % 2 == 1 ? 2 : 1;
        own.second_harmonic_ratio = 0.125 * (1.0 + either_way(random));
        own.second_harmonic_phase_rad = std::numbers::pi * either_way(random);
        own.torque_ripple = motor.max_torque_ripple * (0.75 + 0.25 * either_way(random));
        own.torque_ripple_phase_rad = std::numbers::pi * either_way(random);
    }
    const double share = 0.5 * (1.0 + either_way(random));
    drawn.cable_share = description.structure.cable_share.value_or(share);
    return drawn;
}

void check_options(const device::DeviceDescription &description, const SimulationOptions &options) {
    const device::HandParameters &hand = options.hand;
    constexpr double kMaxSteps = 1e6; // in a period
    const bool finite = std::isfinite(hand.mass_kg) && std::isfinite(hand.damping_Ns_per_m) &&
                        std::isfinite(hand.stiffness_N_per_m) &&
                        std::isfinite(options.servo_period_s);
    const bool good = finite && options.servo_period_s > 0.0 &&
                      options.longest_step_s * kMaxSteps >= options.servo_period_s &&
                      hand.mass_kg >= 0.0 && hand.damping_Ns_per_m >= 0.0 &&
                      hand.stiffness_N_per_m >= 0.0 && hand.max_force_N >= 0.0 &&
                      hand.max_speed_m_per_s > 0.0;
    if (!good) {
        throw InputError("simulated device: the period and the hand's speed must be positive, a "
                         "sub-step at least a millionth of the period, the hand's mass, "
                         "damping, stiffness and force finite and not negative");
    }
    if (!(options.delay_periods >= 0.0 && options.delay_periods <= SimulationOptions::kMaxDelay)) {
        throw InputError("simulated device: the delay is " + std::to_string(options.delay_periods) +
                         " periods; it must be 0 to " +
                         std::to_string(SimulationOptions::kMaxDelay));
    }
    const double brush_voltage_V = options.brush_voltage_V.value_or(0.0);
    if (!(std::isfinite(brush_voltage_V) && brush_voltage_V >= 0.0 &&
          options.brush_current_A > 0.0)) {
        throw InputError("simulated device: the brushes' voltage must be finite and not negative, "
                         "their current positive");
    }
    if (!(options.resistance_share.minCoeff() > 0.0 && options.resistance_share.allFinite()) ||
        !std::isfinite(options.ambient_C)) {
        throw InputError("simulated device: the motors' shares of R must be positive and the "
                         "ambient temperature finite");
    }
    if (options.effects.structural_compliance &&
        !(hand.mass_kg + description.inertia.tip_load_kg > 0.0)) {
        throw InputError("simulated device: a tip behind a compliant structure needs a mass; give "
                         "the hand one, or the device a tip_load_kg");
    }
    check_coupling(options);
}

Vector3 start_angles_rad(const device::DeviceDescription &description,
                         const SimulationOptions &options, const Vector3 &start_tip_m) {
    const std::optional<Vector3> q_rad =
        device::joint_angles_rad(description.geometry, start_tip_m);
    if (!q_rad || (options.effects.joint_limits && !description.joint_limits.allow(*q_rad))) {
        throw InputError("simulated device: its tip cannot start at (" +
                         std::to_string(start_tip_m.x()) + ", " + std::to_string(start_tip_m.y()) +
                         ", " + std::to_string(start_tip_m.z()) +
                         ") m, which is out of reach; choose a point in the workspace");
    }
    return *q_rad;
}

device::DeviceDescription simulated_description(const device::DeviceDescription &description,
                                                const SimulationOptions &options) {
    device::DeviceDescription own = description;
    const bool is_drawn = options.device_seed != 0;
    if (!(is_drawn && options.effects.motor_tolerances)) {
        const Vector3 deviation = (options.resistance_share - Vector3::Ones()).cwiseAbs();
        for (std::size_t j = 0; j < own.motor.size(); ++j) {
            own.motor[j].torque_constant_tolerance = 0.0;
            if (!is_drawn || deviation.isZero(0.0)) {
                own.motor[j].resistance_tolerance = deviation[static_cast<Eigen::Index>(j)];
            }
        }
    }
    if (!(is_drawn && options.effects.current_sensing)) {
        own.current_sensing.gain_tolerance = 0.0;
        own.current_sensing.max_offset_A = 0.0;
    }
    if (!options.quantised_encoders) {
        own.encoder_counts_per_turn *= fine_encoder_factor(description);
    }
    return own;
}

PlantParts plant_parts(const device::DeviceDescription &description,
                       const SimulationOptions &options) {
    check_options(description, options);
    const SampledDevice own = simulated_deviations(description, options);
    const std::array<device::MotorParameters, 3> motor = true_motors(description, options, own);
    device::HandParameters hand = options.hand;
    hand.mass_kg = options.dynamics == PlantDynamics::coupling ? 0.0 : hand.mass_kg;
    const double cable_share = simulated_cable_share(options.effects, own);
    std::optional<device::StructuralCompliance> tip_structure;
    if (options.effects.structural_compliance && cable_share < 1.0) {
        tip_structure = device::tip_compliance(description.structure, cable_share);
    }
    std::optional<std::array<device::CableCompliance, 3>> cables;
    double step_s = options.longest_step_s;
    if (cable_share > 0.0) {
        cables = device::cable_compliance(description, cable_share);
        step_s = std::min(step_s, longest_step_s(*cables, motor));
    }
    return {options.dynamics,
            options.effects,
            step_s,
            options.delay_periods,
            hand,
            linkage_plant(description, options, cables.has_value(), tip_structure.has_value()),
            tip_structure,
            cables,
            motor,
            own,
            {temperature(motor[0], options), temperature(motor[1], options),
             temperature(motor[2], options)}};
}

int fine_encoder_factor(const device::DeviceDescription &description) {
    constexpr double kFiner = 10'000.0;
    const double counts_of_a_turn =
        description.encoder_counts_per_turn * description.geometry.transmission_ratio.maxCoeff();
    const double room = std::numeric_limits<std::int32_t>::max() / counts_of_a_turn;
    return static_cast<int>(std::clamp(room, 1.0, kFiner));
}

} // namespace springdrive::simulated
