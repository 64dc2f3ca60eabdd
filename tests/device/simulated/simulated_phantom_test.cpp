// Covers device/simulated/simulated_phantom.cpp and plant_setup.cpp, and of device/core
// split_delay.h.
#include "device/simulated/simulated_phantom.h"

#include "base/input_error.h"
#include "device/core/phantom/kinematics.h"
#include "device/core/split_delay.h"
#include "device/simulated/plant_setup.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

namespace springdrive::simulated {
namespace {

device::DeviceCommand voltage(const Vector3 &e_W_V, double R_hat_Ohm) {
    return {e_W_V, Vector3::Constant(R_hat_Ohm)};
}

/// Only rigid links, rotors, windings and encoders.
SimulationOptions bare() {
    SimulationOptions options;
    options.effects = PlantEffects::none();
    return options;
}

/// Held by a very stiff hand.
SimulationOptions held() {
    SimulationOptions options = bare();
    options.hand = {1e6, 1e6, 1e9, 1e9, 1.0};
    return options;
}

TEST(SimulatedPhantom, StaysAtRestWhereItStarts) {
    SimulatedPhantom device(testing::phantom_1_0(), bare(), testing::kOffCentre_m);
    const device::Measurement first = device.advance(device::DeviceCommand::braking());
    for (int i = 0; i < 2000; ++i) {
        EXPECT_EQ(device.advance(device::DeviceCommand::braking()).counts, first.counts);
    }
    EXPECT_LT((device.truth().tip_m - testing::kOffCentre_m).norm(), 1e-12);
}

/// A device with a seed, of which only motors and sensors deviate.
SimulationOptions drawn(std::uint64_t seed) {
    SimulationOptions options = held();
    options.effects.motor_tolerances = true;
    options.effects.commutator_phase = true;
    options.effects.commutation_ripple = true;
    options.effects.current_sensing = true;
    options.device_seed = seed;
    return options;
}

/// With the rotor held, e_W + R̂ (g i + o) = R i: what the amplifier's sensor reads is fed back.
TEST(SimulatedPhantom, ASampledDeviceHasItsOwnMotorsAndSensors) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        for (const bool is_shared : {true, false}) {
            device::DeviceDescription description = testing::phantom_1_0();
            description.current_sensing.is_shared = is_shared;
            SimulatedPhantom device(description, drawn(seed), testing::kOffCentre_m);
            const SampledDevice own = sampled_device(description, seed);
            const double R_hat_Ohm = 1.2;
            const Vector3 e_W_V(0.4, -0.3, 0.2);
            Vector3 mean_A = Vector3::Zero();
            constexpr int kMeasured = 4000;
            for (int k = -50; k < kMeasured; ++k) { // settled after some 3 time constants of 0.3 ms
                const device::Measurement read = device.advance(voltage(e_W_V, R_hat_Ohm));
                mean_A += k < 0 ? Vector3::Zero() : Vector3(read.current_A / kMeasured);
            }
            const SimulatedPhantom::Truth &truth = device.truth();
            for (Eigen::Index j = 0; j < 3; ++j) {
                const device::MotorParameters &motor =
                    description.motor[static_cast<std::size_t>(j)];
                const SampledMotor &deviation = own.motor[static_cast<std::size_t>(j)];
                const double turned_rad =
                    deviation.ripples_per_segment * motor.commutator_segments * truth.theta_rad[j];
                const double second = deviation.second_harmonic_ratio;
                const double ripple =
                    motor.commutation_ripple / (1.0 + second) *
                    (std::cos(turned_rad + deviation.commutator_phase_rad) +
                     second * std::cos(2.0 * turned_rad + deviation.second_harmonic_phase_rad));
                const double R_Ohm =
                    deviation.resistance_share * motor.resistance_Ohm * (1.0 + ripple);
                const SensorError &amplifier = deviation.sensing.amplifier;
                const double expected_A = (e_W_V[j] + R_hat_Ohm * amplifier.offset_A) /
                                          (R_Ohm - R_hat_Ohm * amplifier.gain);
                // The hand yields by 1 µm per kN.
                EXPECT_NEAR(truth.current_A[j], expected_A, 1e-6 * std::abs(expected_A));
                // The mean of noise and rounding: five standard errors.
                const SensorError &converter = deviation.sensing.converter;
                const double scatter_A = std::hypot(
                    deviation.sensing.noise_A, deviation.sensing.resolution_A / std::sqrt(12.0));
                EXPECT_NEAR(mean_A[j], converter.gain * expected_A + converter.offset_A,
                            5.0 * scatter_A / std::sqrt(kMeasured));
            }
        }
    }
}

TEST(SimulatedPhantom, DrawnTorqueConstantsMakeTorqueAndBackEmf) {
    const std::uint64_t seed = 3;
    const device::DeviceDescription description = testing::phantom_1_0();
    const SampledDevice own = sampled_device(description, seed);
    const device::DeviceCommand command = voltage(Vector3(0.4, -0.3, 0.2), 1.2);
    SimulatedPhantom pressing(description, drawn(seed), testing::kOffCentre_m);
    for (int k = 0; k < 100; ++k) {
        pressing.advance(command);
    }
    const SimulatedPhantom::Truth &truth = pressing.truth();
    Vector3 torque_Nm;
    for (Eigen::Index j = 0; j < 3; ++j) {
        torque_Nm[j] = description.geometry.transmission_ratio[j] *
                       own.motor[static_cast<std::size_t>(j)].torque_constant_share *
                       description.motor[static_cast<std::size_t>(j)].torque_constant_Nm_per_A *
                       truth.current_A[j];
    }
    const Vector3 q_rad = device::joint_from_motor(description.geometry, truth.theta_rad);
    const Matrix3 J = device::joint_jacobian(description.geometry, q_rad);
    const Vector3 force_N = J.transpose().inverse() * torque_Nm;
    EXPECT_LT((truth.hand_force_N + force_N).norm(), 1e-4 * force_N.norm());

    // Open windings with R̂ = 0 and e_W = 0 brake with k_T²/R: the current of a turning rotor.
    SimulationOptions turning = drawn(seed);
    turning.hand = {};
    SimulatedPhantom braking(description, turning, testing::kOffCentre_m);
    braking.set_in_motion(Vector3(0.5, 0.5, 0.5), Vector3::Zero());
    for (int k = 0; k < 3; ++k) {
        braking.advance(device::DeviceCommand::braking());
    }
    for (Eigen::Index j = 0; j < 3; ++j) {
        const double k_T = own.motor[static_cast<std::size_t>(j)].torque_constant_share *
                           description.motor[static_cast<std::size_t>(j)].torque_constant_Nm_per_A;
        const SimulatedPhantom::Truth &moving = braking.truth();
        // The current lags by L/R, a tenth of a millisecond, in which the speed changes by some
        // hundredths.
        EXPECT_NEAR(-moving.current_A[j] * moving.resistance_Ohm[j] /
                        moving.theta_rate_rad_per_s[j] / k_T,
                    1.0, 0.02)
            << j;
    }
}

TEST(SimulatedPhantom, SwitchesDeviationsOffOneByOne) {
    const device::DeviceDescription description = testing::phantom_1_0();
    const auto resistance_Ohm = [&](const SimulationOptions &options) {
        SimulatedPhantom device(description, options, testing::kOffCentre_m);
        device.advance(device::DeviceCommand::braking());
        return device.truth().resistance_Ohm;
    };
    SimulationOptions options = drawn(4);
    const Vector3 with_all = resistance_Ohm(options);
    options.effects.commutator_phase = false;
    const Vector3 without_phase = resistance_Ohm(options);
    options.effects.motor_tolerances = false;
    const Vector3 nominal = resistance_Ohm(options);
    options.device_seed = 0;
    EXPECT_EQ(nominal, resistance_Ohm(options));
    EXPECT_GT((with_all - without_phase).norm(), 1e-3);
    EXPECT_GT((without_phase - nominal).norm(), 1e-3);
}

TEST(SimulatedPhantom, AnOverCancelledWindingGrowsExponentially) {
    // dR < 0 (docs/design.md, "Where methods fail"): the current grows as e^(|dR| t/L) until the
    // rail.
    SimulationOptions options = held();
    options.effects.amplifier_limits = true;
    SimulatedPhantom device(testing::phantom_1_0(), options, testing::kOffCentre_m);
    const device::MotorParameters &m = device.description().motor[0];
    const double dR = -0.1;
    const device::DeviceCommand command = voltage(Vector3(1e-3, 0.0, 0.0), m.resistance_Ohm - dR);
    double before = 0.0;
    for (int k = 1; k <= 8; ++k) {
        const double current = device.advance(command).current_A[0];
        EXPECT_NEAR(current, 1e-3 / dR * (1.0 - std::exp(-dR * k * 1e-3 / m.inductance_H)),
                    1e-6 * current);
        EXPECT_GT(current, before);
        before = current;
    }
    for (int k = 0; k < 200; ++k) {
        before = device.advance(command).current_A[0];
    }
    // At the supply limit the winding has its full resistance.
    EXPECT_LE(before, m.supply_V / m.resistance_Ohm * (1.0 + 1e-9));
    EXPECT_GT(before, 0.9 * m.supply_V / m.resistance_Ohm);
}

TEST(SimulatedPhantom, ConvergesAtSecondOrder) {
    const auto final_tip = [](double step_s) {
        SimulationOptions options = bare();
        options.longest_step_s = step_s;
        SimulatedPhantom device(testing::phantom_1_0(), options, testing::kOffCentre_m);
        for (int k = 0; k < 40; ++k) {
            device.advance(voltage(Vector3(0.4, -0.3, 0.2) * std::sin(0.3 * k), 1.6));
        }
        return device.truth().tip_m;
    };
    const Vector3 truth = final_tip(1e-3 / 1024);
    const double coarse = (final_tip(1e-3 / 16) - truth).norm();
    const double fine = (final_tip(1e-3 / 32) - truth).norm();
    EXPECT_GT(coarse, 1e-12); // not vacuous
    EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.15);
}

TEST(SimulatedPhantom, EncodersRoundToTheNearestCount) {
    SimulatedPhantom device(testing::phantom_1_0(), {}, testing::kOffCentre_m);
    device.set_hand_target(testing::kOffCentre_m + Vector3(0.02, -0.03, 0.02));
    for (int k = 0; k < 500; ++k) {
        const device::Measurement state = device.advance(device::DeviceCommand::braking());
        const double rad_per_count = 2.0 * std::numbers::pi / 4096;
        for (int j = 0; j < 3; ++j) {
            ASSERT_LE(std::abs(state.counts[static_cast<std::size_t>(j)] * rad_per_count -
                               device.truth().theta_rad[j]),
                      0.5 * rad_per_count + 1e-12);
        }
    }
    EXPECT_GT((device.truth().tip_m - testing::kOffCentre_m).norm(), 0.01); // it moved
}

TEST(SimulatedPhantom, ADelayShiftsTheCommandByWholeSamples) {
    for (int delay = 0; delay <= 3; ++delay) {
        SimulationOptions options = bare();
        options.delay_periods = delay;
        SimulatedPhantom device(testing::phantom_1_0(), options, testing::kOffCentre_m);
        const device::DeviceCommand kick = voltage(Vector3(1.0, 0.0, 0.0), 1.0);
        int silent = 0;
        while (device.advance(kick).current_A[0] < 1e-9) { // round-off of the initial rest
            ++silent;
        }
        EXPECT_EQ(silent, delay);
        EXPECT_EQ(device.delay_periods(), delay);
    }
}

/// A very stiff hand holds the tip: the motor sees θ̇ = 0, and (11) is a plain RL circuit with the
/// closed form i = e_W/dR (1 − e^(−dR t/L)), from (k + d) T on.
TEST(SimulatedPhantom, AHeldRotorRendersTheSeriesSpringAndDamperAfterAnyDelay) {
    std::mt19937 random(5);
    for (int run = 0; run < 20; ++run) {
        SimulationOptions options = held();
        options.delay_periods =
            run == 0 ? 0.0 : std::uniform_real_distribution<double>(0.0, 3.0)(random);
        SimulatedPhantom device(testing::phantom_1_0(), options, testing::kOffCentre_m);
        const double dR = 0.3;
        const device::MotorParameters &m = device.description().motor[0];
        const device::DeviceCommand command =
            voltage(Vector3(0.1, -0.05, 0.02), m.resistance_Ohm - dR);
        for (int k = 1; k <= 8; ++k) {
            const Vector3 current_A = device.advance(command).current_A;
            const double since_s = std::max(0.0, k - options.delay_periods) * 1e-3;
            const Vector3 expected_A =
                command.e_W_V / dR * (1.0 - std::exp(-dR * since_s / m.inductance_H));
            // The hand yields by 1 µm per kN; the remaining k_T θ̇ is below 1e-7 of e_W.
            EXPECT_LT((current_A - expected_A).norm(), 1e-6 * expected_A.norm() + 1e-12)
                << "d = " << options.delay_periods << ", k = " << k;
        }
        EXPECT_NEAR(device.truth().time_s, 8e-3, 1e-15 * 100); // round-off of the sub-steps
    }
}

TEST(SimulatedPhantom, NumbersAndTimesItsMeasurementsWhateverItsPeriod) {
    SimulatedPhantom device(testing::phantom_1_0(), bare(), testing::kOffCentre_m);
    double time_s = 0.0;
    std::uint64_t number = 0;
    for (const double period_s : {1e-3, 0.25e-3, 4e-3, 1e-3}) {
        device.set_period(period_s);
        for (int i = 0; i < 7; ++i) {
            const device::Measurement measured = device.read();
            time_s += period_s;
            EXPECT_EQ(measured.number, ++number);
            EXPECT_NEAR(measured.time_s, time_s, 1e-15 * static_cast<double>(number));
            EXPECT_NEAR(device.truth().time_s, time_s, 1e-12);
            EXPECT_EQ(measured.arrival, device::Arrival::fresh);
        }
    }
    EXPECT_THROW(device.set_period(0.0), InputError);
    EXPECT_THROW(device.set_period(NAN), InputError);
}

TEST(SimulatedPhantom, TheLastCommandIsHeldUntilTheNext) {
    SimulatedPhantom written(testing::phantom_1_0(), {}, testing::kOffCentre_m);
    SimulatedPhantom held_on(testing::phantom_1_0(), {}, testing::kOffCentre_m);
    const device::DeviceCommand command = voltage(Vector3(0.3, -0.2, 0.1), 1.0);
    held_on.write(command);
    for (int i = 0; i < 50; ++i) {
        EXPECT_EQ(written.advance(command).counts, held_on.read().counts);
    }
    EXPECT_EQ(written.truth().tip_m, held_on.truth().tip_m);
}

TEST(SimulatedPhantom, OpenWindingsCarryNoCurrentAndBrakingOnesBrake) {
    SimulationOptions options = bare();
    options.hand = {0.0, 0.0, 0.0, 0.0, 1.0};
    device::DeviceCommand open = voltage(Vector3(1.0, 1.0, 1.0), 1.0); // ignores the values
    open.mode = device::CommandMode::open;
    device::DeviceCommand brake = open;
    brake.mode = device::CommandMode::brake;
    const Vector3 rate(0.5, 0.4, -0.3);
    SimulatedPhantom coasting(testing::phantom_1_0(), options, testing::kOffCentre_m);
    SimulatedPhantom braking(testing::phantom_1_0(), options, testing::kOffCentre_m);
    SimulatedPhantom shorted(testing::phantom_1_0(), options, testing::kOffCentre_m);
    for (SimulatedPhantom *const device : {&coasting, &braking, &shorted}) {
        device->set_in_motion(rate, Vector3::Zero());
    }
    const double energy_J = coasting.stored_energy_J();
    for (int i = 0; i < 100; ++i) {
        EXPECT_TRUE(coasting.advance(open).current_A.isZero(0.0));
        braking.advance(brake);
        shorted.advance(device::DeviceCommand::braking());
    }
    EXPECT_NEAR(coasting.stored_energy_J(), energy_J, 1e-9 * energy_J); // round-off: no loss at all
    EXPECT_LT(braking.stored_energy_J(), 0.9 * energy_J);
    EXPECT_EQ(braking.truth().theta_rad, shorted.truth().theta_rad);
}

TEST(SimulatedPhantom, CountsFromWhereItIsZeroed) {
    SimulatedPhantom device(testing::phantom_1_0(), {}, testing::kOffCentre_m);
    const device::Measurement before = device.read();
    const double per_count = device.description().rad_per_count();
    const Vector3 theta_rad = device.truth().theta_rad;
    device.zero(theta_rad + Vector3(1.0, -2.0, 3.0));
    const device::Measurement after = device.read();
    for (std::size_t j = 0; j < 3; ++j) {
        const double moved = per_count * (after.counts[j] - before.counts[j]);
        EXPECT_NEAR(moved, (std::array{1.0, -2.0, 3.0}[j]), 2.0 * per_count);
    }
}

TEST(SimulatedPhantom, IsLostAndBrakesWhileClosedAndCountsFromZeroAfterReconnecting) {
    SimulatedPhantom device(testing::phantom_1_0(), {}, testing::kOffCentre_m);
    const device::DeviceCommand command = voltage(Vector3(0.3, 0.0, 0.0), 1.0);
    for (int i = 0; i < 20; ++i) {
        device.advance(command);
    }
    device.close();
    for (int i = 0; i < 500; ++i) {
        const device::Measurement measured = device.advance(command);
        EXPECT_EQ(measured.health, device::DeviceHealth::lost);
        EXPECT_EQ(measured.arrival, device::Arrival::absent);
    }
    EXPECT_LT(device.truth().current_A.norm(), 1e-3); // no drive
    device.reconnect();
    const device::Measurement back = device.read();
    EXPECT_EQ(back.health, device::DeviceHealth::ok);
    EXPECT_EQ(back.counts, (std::array<std::int32_t, 3>{}));
    EXPECT_FALSE(device.identity().kind.empty());
}

TEST(SimulatedPhantom, TheHandsForceIsLimited) {
    SimulationOptions options;
    SimulatedPhantom device(testing::phantom_1_0(), options, testing::kOffCentre_m);
    // Shorted windings brake while the target moves away at its maximum speed.
    device.set_hand_target(testing::kOffCentre_m + Vector3(0.5, 0.0, 0.0));
    const double maximum = options.hand.max_force_N +
                           2.0 * options.hand.damping_Ns_per_m * options.hand.max_speed_m_per_s;
    for (int k = 0; k < 300; ++k) {
        device.advance(device::DeviceCommand::braking());
        ASSERT_LT(device.truth().hand_force_N.norm(), maximum);
    }
}

TEST(SimulatedPhantom, ACommandThatIsNotFiniteBrakes) {
    SimulatedPhantom device(testing::phantom_1_0(), bare(), testing::kOffCentre_m);
    device.advance(voltage(Vector3(NAN, 1.0, INFINITY), 1.0));
    EXPECT_LT(device.truth().current_A.norm(), 1e-12); // round-off of the initial rest
    EXPECT_TRUE(device.truth().tip_m.allFinite());
}

TEST(SimulatedPhantom, RejectsAStartOutOfReachAndAnInvalidDelay) {
    const device::DeviceDescription description = testing::phantom_1_0();
    EXPECT_THROW(SimulatedPhantom(description, {}, Vector3(1.0, 0.0, 0.0)), InputError);
    // Within reach, but the links fold further than their stops allow: 70° instead of 65°.
    const Vector3 folded_m = device::tip_position_m(
        description.geometry, Vector3(0.0, 0.7, 0.7 - 70.0 * std::numbers::pi / 180));
    EXPECT_THROW(SimulatedPhantom(description, {}, folded_m), InputError);
    SimulationOptions options = bare();
    EXPECT_NO_THROW(SimulatedPhantom(description, options, folded_m));
    options.delay_periods = -1;
    EXPECT_THROW(SimulatedPhantom(description, options, testing::kOffCentre_m), InputError);
    options.delay_periods = SimulationOptions::kMaxDelay + 1;
    EXPECT_THROW(SimulatedPhantom(description, options, testing::kOffCentre_m), InputError);
}

/// All deviations of a device, each relative to its tolerance.
std::vector<double> deviations(const device::DeviceDescription &device, std::uint64_t seed) {
    std::vector<double> found;
    const SampledDevice drawn = sampled_device(device, seed);
    for (std::size_t j = 0; j < 3; ++j) {
        const SampledMotor &own = drawn.motor[j];
        const device::MotorParameters &motor = device.motor[j];
        found.push_back((own.resistance_share - 1.0) / motor.resistance_tolerance);
        found.push_back((own.torque_constant_share - 1.0) / motor.torque_constant_tolerance);
        found.push_back(own.commutator_phase_rad / std::numbers::pi);
        for (const SensorError &sensor : {own.sensing.converter, own.sensing.amplifier}) {
            found.push_back((sensor.gain - 1.0) / device.current_sensing.gain_tolerance);
            found.push_back(sensor.offset_A / device.current_sensing.max_offset_A);
        }
        const auto on_scale = [](double value, double min, double max) {
            return 2.0 * std::log(value / min) / std::log(max / min) - 1.0;
        };
        const double max_V = motor.max_brush_voltage_V;
        found.push_back(on_scale(own.brush_voltage_V, max_V / 50.0, max_V));
        found.push_back(on_scale(own.brush_current_A, 0.01, 0.2));
        found.push_back(on_scale(own.carried_brush_current_A, 0.01, 0.2));
        found.push_back(on_scale(own.brush_film_s, 2.0, 60.0));
        found.push_back(on_scale(own.winding_housing_share, 0.5, 2.0));
        found.push_back(8.0 * own.second_harmonic_ratio - 1.0);
        found.push_back(own.second_harmonic_phase_rad / std::numbers::pi);
        found.push_back(4.0 * own.torque_ripple / motor.max_torque_ripple - 3.0);
        found.push_back(own.torque_ripple_phase_rad / std::numbers::pi);
    }
    return found;
}

TEST(SampledDevice, IsThatOfTheFileForSeedZero) {
    const SampledDevice drawn = sampled_device(testing::phantom_1_0(), 0);
    for (const SampledMotor &own : drawn.motor) {
        EXPECT_EQ(own.resistance_share, 1.0);
        EXPECT_EQ(own.torque_constant_share, 1.0);
        EXPECT_EQ(own.commutator_phase_rad, 0.0);
        EXPECT_EQ(own.sensing.converter.gain, 1.0);
        EXPECT_EQ(own.sensing.amplifier.offset_A, 0.0);
        EXPECT_EQ(own.sensing.noise_A, 0.0);
        EXPECT_EQ(own.winding_housing_share, 1.0);
        EXPECT_EQ(own.brush_voltage_V, 0.0);
        EXPECT_EQ(own.ripples_per_segment, 1);
        EXPECT_EQ(own.second_harmonic_ratio, 0.0);
        EXPECT_EQ(own.torque_ripple, 0.0);
    }
}

/// What was drawn before there were brushes, kept so that a seed names the same device.
TEST(SampledDevice, KeepsTheMotorsAndSensorsOfItsSeed) {
    const SampledMotor own = sampled_device(testing::phantom_1_0(), 7).motor[2];
    EXPECT_NEAR(own.resistance_share, 1.0332168372376, 1e-12);
    EXPECT_NEAR(own.torque_constant_share, 0.9882403098655, 1e-12);
    EXPECT_NEAR(own.commutator_phase_rad, 3.1118218332226, 1e-12);
    EXPECT_NEAR(own.sensing.converter.offset_A, 0.0146617004374, 1e-12);
}

/// One in two of an odd number of segments, and none of an even one: within five standard errors.
TEST(SampledDevice, CommutatesTwiceASegmentOnlyIfTheyAreOdd) {
    device::DeviceDescription device = testing::phantom_1_0();
    for (const int segments : {11, 12}) {
        device.motor[1].commutator_segments = segments;
        constexpr int kSeeds = 1000;
        int twice = 0;
        for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
            twice += sampled_device(device, seed).motor[1].ripples_per_segment == 2 ? 1 : 0;
        }
        EXPECT_NEAR(twice, segments % 2 * 0.5 * kSeeds,
                    5.0 * 0.5 * std::sqrt(kSeeds) * (segments % 2));
    }
}

/// Uniform within the tolerances, and independent: mean 0, variance 1/3, no correlation. Bounds of
/// five standard errors: one in a million if it is so, for each of some 1,200 comparisons.
TEST(SampledDevice, IsUniformWithinTheTolerances) {
    device::DeviceDescription device = testing::phantom_1_0();
    device.current_sensing.is_shared = false;
    constexpr int kSeeds = 4000;
    const std::size_t count = deviations(device, 1).size();
    std::vector<double> sum(count);
    std::vector<std::vector<double>> products(count, std::vector<double>(count));
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
        const std::vector<double> drawn = deviations(device, seed);
        for (std::size_t i = 0; i < count; ++i) {
            ASSERT_LE(std::abs(drawn[i]), 1.0 + 1e-12);
            sum[i] += drawn[i];
            for (std::size_t k = 0; k <= i; ++k) {
                products[i][k] += drawn[i] * drawn[k];
            }
        }
    }
    const double root = std::sqrt(kSeeds);
    for (std::size_t i = 0; i < count; ++i) {
        EXPECT_LT(std::abs(sum[i] / kSeeds), 5.0 * std::sqrt(1.0 / 3.0) / root) << i;
        // The variance of u² is 4/45, of a product of two 1/9.
        EXPECT_NEAR(products[i][i] / kSeeds, 1.0 / 3.0, 5.0 * std::sqrt(4.0 / 45.0) / root) << i;
        for (std::size_t k = 0; k < i; ++k) {
            EXPECT_LT(std::abs(products[i][k] / kSeeds), 5.0 / 3.0 / root) << i << ' ' << k;
        }
    }
}

TEST(SampledDevice, MayHaveOneSensorForBoth) {
    device::DeviceDescription device = testing::phantom_1_0();
    for (const bool is_shared : {true, false}) {
        device.current_sensing.is_shared = is_shared;
        const MotorSensing sensing = sampled_device(device, 7).motor[1].sensing;
        EXPECT_EQ(sensing.converter.gain == sensing.amplifier.gain, is_shared);
        EXPECT_EQ(sensing.converter.offset_A == sensing.amplifier.offset_A, is_shared);
    }
}

TEST(SplitDelay, AddsUpExactly) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> delays(0.0, 16.0);
    for (int i = 0; i < 1000; ++i) {
        const double d = delays(random);
        const device::SplitDelay split = device::split_delay(d);
        EXPECT_EQ(split.whole + split.fraction, d);
        EXPECT_GE(split.fraction, 0.0);
        EXPECT_LT(split.fraction, 1.0);
        EXPECT_EQ(split.held(), std::ceil(d));
    }
}

TEST(SplitDelay, BothSidesOfWholeNumbers) {
    for (const int whole : {0, 1, 2, 8}) {
        EXPECT_EQ(device::split_delay(whole).whole, whole);
        EXPECT_EQ(device::split_delay(whole).fraction, 0.0);
        EXPECT_EQ(device::split_delay(whole).held(), whole);
        const double above = std::nextafter(static_cast<double>(whole), 99.0);
        EXPECT_EQ(device::split_delay(above).whole, whole);
        EXPECT_GT(device::split_delay(above).fraction, 0.0);
        EXPECT_EQ(device::split_delay(above).held(), whole + 1);
    }
    EXPECT_EQ(device::split_delay(std::nextafter(2.0, 0.0)).whole, 1);
    EXPECT_EQ(device::split_delay(std::nextafter(2.0, 0.0)).held(), 2);
}

} // namespace
} // namespace springdrive::simulated
