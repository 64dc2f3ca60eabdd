// Covers device/simulated/brushes.cpp, and of plant_setup.cpp and simulated_phantom.cpp what motors
// are beyond their data sheet: brushes and their film, k_T(T, θ), and the winding's heat path.
#include "device/core/phantom/kinematics.h"
#include "device/simulated/simulated_phantom.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>

namespace springdrive::simulated {
namespace {

constexpr double kTick_s = 1e-3;

/// Only rigid links, rotors, windings and encoders; a hand so stiff that no rotor turns.
SimulationOptions locked() {
    SimulationOptions options;
    options.effects = PlantEffects::none();
    options.hand = {1e6, 1e6, 1e9, 1e9, 1.0};
    return options;
}

device::DeviceCommand command_of(double e_W_V, double R_hat_Ohm) {
    return {Vector3::Constant(e_W_V), Vector3::Constant(R_hat_Ohm)};
}

struct Brushes {
    double voltage_V = 0.0;
    double current_A = 0.0;
};

/// L di/dt = e − dR i − V_b tanh(i/i_b), by Runge and Kutta's method of fourth order in steps of
/// 1 µs, a fifth of the shortest time constant L i_b/V_b here.
struct LockedWinding {
    double L_H = 0.0;
    double dR_Ohm = 0.0;
    Brushes brushes;
    double current_A = 0.0;

    void advance(double e_V) {
        constexpr int kSteps = 1000;
        constexpr double kStep_s = kTick_s / kSteps;
        const auto rate = [&](double i_A) {
            return (e_V - dR_Ohm * i_A - brushes.voltage_V * std::tanh(i_A / brushes.current_A)) /
                   L_H;
        };
        for (int k = 0; k < kSteps; ++k) {
            const double a = rate(current_A);
            const double b = rate(current_A + 0.5 * kStep_s * a);
            const double c = rate(current_A + 0.5 * kStep_s * b);
            const double d = rate(current_A + kStep_s * c);
            current_A += kStep_s / 6.0 * (a + 2.0 * b + 2.0 * c + d);
        }
    }
};

class BrushVoltage : public ::testing::TestWithParam<Brushes> {};

TEST_P(BrushVoltage, ALockedRotorsCurrentGoesToItsBalance) {
    const device::DeviceDescription description = testing::phantom_1_0();
    const double dR_Ohm = 0.2;
    const double R_Ohm = description.motor[0].resistance_Ohm;
    for (const double e_V : {0.3, -0.6, 1.2}) {
        SimulationOptions options = locked();
        options.brush_voltage_V = GetParam().voltage_V;
        options.brush_current_A = GetParam().current_A;
        SimulatedPhantom device(description, options, testing::kOffCentre_m);
        for (int k = 0; k < 100; ++k) { // L/dR is 1.2 ms
            device.advance(command_of(e_V, R_Ohm - dR_Ohm));
        }
        for (const double i_A : device.truth().current_A) {
            EXPECT_NEAR(dR_Ohm * i_A + GetParam().voltage_V * std::tanh(i_A / GetParam().current_A),
                        e_V, 1e-7); // the hand still yields by 1 µm/s
        }
    }
}

TEST_P(BrushVoltage, ALockedRotorsCurrentIsThatOfItsEquation) {
    const device::DeviceDescription description = testing::phantom_1_0();
    const double dR_Ohm = 0.2;
    const device::MotorParameters &motor = description.motor[0];
    SimulationOptions options = locked();
    options.brush_voltage_V = GetParam().voltage_V;
    options.brush_current_A = GetParam().current_A;
    SimulatedPhantom device(description, options, testing::kOffCentre_m);
    LockedWinding winding{motor.inductance_H, dR_Ohm, GetParam()};
    std::mt19937_64 random(3);
    double square_A2 = 0.0;
    double difference_A2 = 0.0;
    for (int k = 0; k < 2000; ++k) { // strokes of 5 Hz, with the noise of counts in velocity
        const double noise_V = 0.1 * (2.0 * std::generate_canonical<double, 53>(random) - 1.0);
        const double e_V = 1.2 * std::sin(0.0314 * k) + noise_V;
        device.advance(command_of(e_V, motor.resistance_Ohm - dR_Ohm));
        winding.advance(e_V);
        square_A2 += winding.current_A * winding.current_A;
        difference_A2 += std::pow(device.truth().current_A[0] - winding.current_A, 2);
    }
    // Second order where L i_b/V_b is far above the sub-step of 100 µs. Where it is 5 µs, the
    // current is some 20 mA behind for a time of L/dR whenever it leaves zero.
    EXPECT_LT(std::sqrt(difference_A2 / square_A2), 2e-3);
    EXPECT_GT(square_A2 / 2000, 0.1);
}

INSTANTIATE_TEST_SUITE_P(Motors, BrushVoltage,
                         ::testing::Values(Brushes{0.02, 0.01}, Brushes{0.02, 0.2},
                                           Brushes{0.5, 0.01}, Brushes{0.5, 0.2}),
                         [](const auto &instance) {
                             return "V" +
                                    std::to_string(std::lround(1e3 * instance.param.voltage_V)) +
                                    "mVI" +
                                    std::to_string(std::lround(1e3 * instance.param.current_A)) +
                                    "mA";
                         });

/// The supply less V_b is left for R: both amplifiers, and with windings that store nothing.
TEST(BrushVoltages, CountAgainstTheSupply) {
    const device::DeviceDescription description = testing::phantom_1_0();
    const device::MotorParameters &motor = description.motor[0];
    for (const auto amplifier :
         {device::AmplifierKind::spring_drive, device::AmplifierKind::current_drive}) {
        for (const auto dynamics : {PlantDynamics::electromechanical, PlantDynamics::rigid_body}) {
            SimulationOptions options = locked();
            options.effects.amplifier_limits = true;
            options.amplifier = amplifier;
            options.dynamics = dynamics;
            options.resistance_share.setConstant(1.5); // so that the peak current is not reached
            options.brush_voltage_V = 0.5;
            SimulatedPhantom device(description, options, testing::kOffCentre_m);
            for (int k = 0; k < 50; ++k) {
                device.advance(PlantCommand{command_of(11.0, 1.0), Vector3::Constant(4.0)});
            }
            EXPECT_NEAR(device.truth().current_A[0],
                        (motor.supply_V - 0.5) / (1.5 * motor.resistance_Ohm),
                        1e-4); // of the 0.15 A that V_b costs
        }
    }
}

TEST(BrushVoltages, AFilmFollowsTheMeanCurrent) {
    const device::DeviceDescription description = testing::phantom_1_0();
    const std::uint64_t seed = 5;
    SimulationOptions options = locked();
    options.effects.brush_voltage = true;
    options.device_seed = seed;
    options.amplifier = device::AmplifierKind::current_drive;
    SimulatedPhantom device(description, options, testing::kOffCentre_m);
    const double command_A = 0.7;
    for (int k = 1; k <= 8000; ++k) {
        device.advance(PlantCommand{{}, Vector3::Constant(-command_A)});
        for (Eigen::Index j = 0; j < 3; ++j) {
            const SampledMotor own =
                sampled_device(description, seed).motor[static_cast<std::size_t>(j)];
            const double mean_A = -command_A * std::expm1(-kTick_s * k / own.brush_film_s);
            const double share = mean_A / (mean_A + 0.3);
            // A period in 2 s of the film, and the current's 0.1 ms.
            ASSERT_NEAR(device.truth().brush_current_A[j],
                        own.brush_current_A +
                            share * (own.carried_brush_current_A - own.brush_current_A),
                        2e-4);
        }
    }
}

/// What motors make of their currents, and of motion.
struct TorqueAndBackEmf {
    Vector3 torque_Nm_per_A;
    Vector3 back_emf_Vs_per_rad;
};

TorqueAndBackEmf measured(const device::DeviceDescription &description,
                          const SimulationOptions &options) {
    SimulatedPhantom pressing(description, options, testing::kOffCentre_m);
    for (int k = 0; k < 100; ++k) {
        pressing.advance(device::DeviceCommand{Vector3(0.4, -0.3, 0.2), Vector3::Constant(1.2)});
    }
    const SimulatedPhantom::Truth &truth = pressing.truth();
    const Matrix3 J = device::joint_jacobian(
        description.geometry, device::joint_from_motor(description.geometry, truth.theta_rad));
    const Vector3 torque_Nm = J.transpose() * -truth.hand_force_N;
    TorqueAndBackEmf measured;
    measured.torque_Nm_per_A = torque_Nm.cwiseQuotient(
        description.geometry.transmission_ratio.cwiseProduct(truth.current_A));

    SimulationOptions turning = options;
    turning.hand = {};
    SimulatedPhantom braking(description, turning, testing::kOffCentre_m);
    braking.set_in_motion(Vector3(0.5, 0.5, 0.5), Vector3::Zero());
    for (int k = 0; k < 3; ++k) {
        braking.advance(device::DeviceCommand::braking());
    }
    measured.back_emf_Vs_per_rad = -braking.truth()
                                        .current_A.cwiseProduct(braking.truth().resistance_Ohm)
                                        .cwiseQuotient(braking.truth().theta_rate_rad_per_s);
    return measured;
}

TEST(MagnetHeat, KtOfTorqueAndBackEmfFallsWithTheHousing) {
    const device::DeviceDescription description = testing::phantom_1_0();
    SimulationOptions options = locked();
    options.effects.winding_heat = true;
    const TorqueAndBackEmf cold = measured(description, options);
    options.ambient_C = 65.0;
    for (const bool falls : {false, true}) {
        options.effects.magnet_heat = falls;
        const TorqueAndBackEmf warm = measured(description, options);
        const double share =
            falls ? 1.0 - 40.0 * description.motor[0].torque_constant_fall_per_K : 1.0;
        for (Eigen::Index j = 0; j < 3; ++j) {
            // The hand yields by 1 µm per kN, and the housing gains some mK.
            EXPECT_NEAR(warm.torque_Nm_per_A[j] / cold.torque_Nm_per_A[j], share, 1e-4);
            // R, and with it the lag L/R of a current in a changing motion, rises by a sixth.
            EXPECT_NEAR(warm.back_emf_Vs_per_rad[j] / cold.back_emf_Vs_per_rad[j], share, 5e-3);
        }
    }
}

TEST(MagnetHeat, IsOfTheHousingThatCurrentWarms) {
    device::DeviceDescription description = testing::phantom_1_0();
    for (device::MotorParameters &motor : description.motor) {
        motor.thermal.winding_time_s = 0.1;
        motor.thermal.motor_time_s = 3.0;
    }
    SimulationOptions options = locked();
    options.effects.winding_heat = true;
    options.effects.magnet_heat = true;
    SimulatedPhantom device(description, options, testing::kOffCentre_m);
    for (int k = 0; k < 2000; ++k) {
        device.advance(command_of(0.3, 2.0));
    }
    const SimulatedPhantom::Truth &truth = device.truth();
    for (Eigen::Index j = 0; j < 3; ++j) {
        EXPECT_GT(truth.housing_C[j], 30.0);
        const device::MotorParameters &motor = description.motor[static_cast<std::size_t>(j)];
        EXPECT_DOUBLE_EQ(truth.torque_constant_Nm_per_A[j],
                         motor.torque_constant_Nm_per_A * (1.0 - motor.torque_constant_fall_per_K *
                                                                     (truth.housing_C[j] - 25.0)));
    }
}

/// A device of a seed with nothing but ripple of k_T.
SimulationOptions rippling(std::uint64_t seed) {
    SimulationOptions options;
    options.effects = PlantEffects::none();
    options.effects.torque_ripple = true;
    options.effects.commutator_phase = true;
    options.device_seed = seed;
    options.hand = {0.05, 0.0, 0.0, 0.0, 1.0};
    return options;
}

/// With dR = 0 the windings are springs, (4): energy goes to and fro between them and the links,
/// and none is made or lost if torque and back-EMF have the same k_T(θ).
TEST(TorqueRipple, MakesNoEnergy) {
    const device::DeviceDescription description = testing::phantom_1_0();
    const double R_Ohm = description.motor[0].resistance_Ohm;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        SimulationOptions options = rippling(seed);
        SimulatedPhantom device(description, options, testing::kOffCentre_m);
        options.effects.torque_ripple = false;
        SimulatedPhantom smooth(description, options, testing::kOffCentre_m);
        for (SimulatedPhantom *const each : {&device, &smooth}) {
            each->set_in_motion(Vector3(3.0, -2.0, 2.5), Vector3::Zero());
        }
        const double energy_J = device.stored_energy_J();
        double most_in_windings = 0.0;
        double apart_A = 0.0;
        for (int k = 0; k < 1000; ++k) {
            device.advance(command_of(0.0, R_Ohm));
            smooth.advance(command_of(0.0, R_Ohm));
            // 10,000 sub-steps whose round-off accumulates like a random walk.
            ASSERT_NEAR(device.stored_energy_J(), energy_J, 1e-12 * energy_J) << k;
            const double in_windings_J =
                0.5 * description.motor[0].inductance_H * device.truth().current_A.squaredNorm();
            most_in_windings = std::max(most_in_windings, in_windings_J / energy_J);
            apart_A =
                std::max(apart_A, (device.truth().current_A - smooth.truth().current_A).norm());
        }
        EXPECT_GT(most_in_windings, 0.5);
        EXPECT_GT(apart_A, 0.01);
    }
}

TEST(TorqueRipple, HasThePeriodsAndTheAmplitudeOfItsDevice) {
    const device::DeviceDescription description = testing::phantom_1_0();
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        SimulationOptions options = rippling(seed);
        options.effects.motor_tolerances = true; // as of R's ripple
        SimulatedPhantom device(description, options, testing::kOffCentre_m);
        device.set_in_motion(Vector3(1.0, 1.0, 1.0), Vector3::Zero());
        device::DeviceCommand open;
        open.mode = device::CommandMode::open;
        for (int k = 0; k < 300; ++k) {
            device.advance(open);
            for (std::size_t j = 0; j < 3; ++j) {
                const SampledMotor own = sampled_device(description, seed).motor[j];
                const device::MotorParameters &motor = description.motor[j];
                const auto axis = static_cast<Eigen::Index>(j);
                const int periods = own.ripples_per_segment * motor.commutator_segments;
                ASSERT_NEAR(device.truth().torque_constant_Nm_per_A[axis] /
                                (own.torque_constant_share * motor.torque_constant_Nm_per_A),
                            1.0 + own.torque_ripple *
                                      std::cos(periods * device.truth().theta_rad[axis] +
                                               own.torque_ripple_phase_rad),
                            1e-12);
            }
        }
    }
}

/// Behind a constant power the winding is warmer than the housing by R_wh of its own, less what
/// still warms the copper: as the housing's heat capacity is 200 times that, half a hundredth.
TEST(MotorTolerances, AWindingsHeatHasItsOwnWay) {
    device::DeviceDescription description = testing::phantom_1_0();
    for (device::MotorParameters &motor : description.motor) {
        motor.resistance_rise_per_K = 0.0;
        motor.thermal.winding_time_s = 0.5;
    }
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        SimulationOptions options = locked();
        options.amplifier = device::AmplifierKind::current_drive;
        options.device_seed = seed;
        options.effects.winding_heat = true;
        options.effects.motor_tolerances = true;
        options.longest_step_s = kTick_s;
        SimulatedPhantom device(description, options, testing::kOffCentre_m);
        for (int k = 0; k < 8000; ++k) {
            device.advance(PlantCommand{{}, Vector3::Constant(2.0)});
        }
        const SimulatedPhantom::Truth &truth = device.truth();
        for (std::size_t j = 0; j < 3; ++j) {
            const auto axis = static_cast<Eigen::Index>(j);
            const SampledMotor own = sampled_device(description, seed).motor[j];
            const double rise_K = own.winding_housing_share *
                                  description.motor[j].thermal.winding_housing_K_per_W *
                                  truth.resistance_Ohm[axis] * 4.0;
            EXPECT_NEAR((truth.winding_C[axis] - truth.housing_C[axis]) / rise_K, 1.0, 1e-2);
        }
    }
}

/// Exactly the plant without it.
TEST(PlantEffect, SwitchedOffIsAsIfTheFileDidNotHaveIt) {
    const device::DeviceDescription file = testing::phantom_1_0();
    using Motor = device::MotorParameters;
    const auto run = [](const device::DeviceDescription &description, const PlantEffects &effects) {
        SimulationOptions options;
        options.effects = effects;
        options.device_seed = 9;
        options.ambient_C = 33.0;
        SimulatedPhantom device(description, options, testing::kOffCentre_m);
        device.set_hand_target(testing::kOffCentre_m + Vector3(0.02, -0.01, 0.015));
        for (int k = 0; k < 300; ++k) {
            device.advance(command_of(0.4 * std::sin(0.05 * k), 1.6));
        }
        return device.truth().current_A;
    };
    const Vector3 with_all_A = run(file, {});
    for (const auto &[of_file, of_plant] :
         {std::pair(&Motor::max_brush_voltage_V, &PlantEffects::brush_voltage),
          {&Motor::max_torque_ripple, &PlantEffects::torque_ripple},
          {&Motor::torque_constant_fall_per_K, &PlantEffects::magnet_heat}}) {
        device::DeviceDescription without = file;
        for (Motor &motor : without.motor) {
            motor.*of_file = 0.0;
        }
        PlantEffects effects;
        effects.*of_plant = false;
        EXPECT_EQ(run(file, effects), run(without, {}));
        EXPECT_GT((run(file, effects) - with_all_A).norm(), 1e-4);
    }
}

} // namespace
} // namespace springdrive::simulated
