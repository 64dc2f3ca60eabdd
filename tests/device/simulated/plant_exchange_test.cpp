// Covers SimulatedPhantom::simulate_as: changes of the model while the device runs.
#include "base/input_error.h"
#include "device/core/phantom/kinematics.h"
#include "device/simulated/simulated_phantom.h"
#include "device/simulated/simulation_options.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

namespace springdrive::simulated {
namespace {

const Vector3 kSideways_m(0.02, 0.0, 0.0);

SimulationOptions simulating(const PlantModel &model, bool planar = false) {
    SimulationOptions options;
    options.dynamics = model.dynamics;
    options.effects = model.effects;
    options.planar = planar;
    return options;
}

device::Measurement run(SimulatedPhantom &device, int ticks,
                        const device::DeviceCommand &command = device::DeviceCommand::braking()) {
    device::Measurement state;
    for (int k = 0; k < ticks; ++k) {
        state = device.advance(command);
    }
    return state;
}

double sideways_m(const SimulatedPhantom &device) { return device.truth().tip_m.x(); }

TEST(PlantExchange, ALockedBaseIsReleased) {
    for (const PlantModel &model : kPlantModels) {
        SimulatedPhantom device(testing::phantom_1_0(), simulating(model, true),
                                testing::kOffCentre_m);
        device.set_hand_target(testing::kOffCentre_m + kSideways_m);
        const double held_rad = device.truth().theta_rad[0];
        run(device, 500);
        EXPECT_EQ(device.truth().theta_rad[0], held_rad) << model.name;
        device.simulate_as(simulating(model, false));
        run(device, 1000);
        // A hand of 300 N/m against about 0.05 N of friction and weight, and the structure.
        EXPECT_NEAR(sideways_m(device), (testing::kOffCentre_m + kSideways_m).x(), 2e-3)
            << model.name;
    }
}

TEST(PlantExchange, AMovingBaseIsNotLocked) {
    SimulatedPhantom device(testing::phantom_1_0(), simulating(kPlantModels.back()),
                            testing::kOffCentre_m);
    device.simulate_as(simulating(kPlantModels.back(), true));
    device.set_hand_target(testing::kOffCentre_m + kSideways_m);
    run(device, 1000);
    EXPECT_NEAR(sideways_m(device), (testing::kOffCentre_m + kSideways_m).x(), 2e-3);
}

TEST(PlantExchange, ALockedBaseStaysLockedInAnotherModel) {
    SimulatedPhantom device(testing::phantom_1_0(), simulating(kPlantModels.front(), true),
                            testing::kOffCentre_m);
    device.set_hand_target(testing::kOffCentre_m + kSideways_m);
    const double held_rad = device.truth().theta_rad[0];
    run(device, 100);
    device.simulate_as(simulating(kPlantModels.back(), true));
    run(device, 100);
    EXPECT_EQ(device.truth().theta_rad[0], held_rad);
}

TEST(PlantExchange, TheSameModelAgainChangesNothing) {
    for (const PlantModel &model : kPlantModels) {
        SimulatedPhantom once(testing::phantom_1_0(), simulating(model), testing::kOffCentre_m);
        SimulatedPhantom again(testing::phantom_1_0(), simulating(model), testing::kOffCentre_m);
        for (int k = 0; k < 300; ++k) {
            if (k % 50 == 7) {
                again.simulate_as(simulating(model));
            }
            const device::DeviceCommand command{Vector3(0.6, -0.4, 0.5) * std::sin(0.05 * k),
                                                Vector3::Constant(1.5)};
            EXPECT_EQ(once.advance(command).counts, again.advance(command).counts);
            ASSERT_EQ(once.truth().tip_m, again.truth().tip_m) << model.name << " at " << k;
            ASSERT_EQ(once.truth().current_A, again.truth().current_A);
        }
    }
}

TEST(PlantExchange, NoEncoderJumpsFromOneModelToAnyOther) {
    for (const PlantModel &from : kPlantModels) {
        for (const PlantModel &to : kPlantModels) {
            SimulatedPhantom device(testing::phantom_1_0(), simulating(from),
                                    testing::kOffCentre_m);
            device.set_hand_target(testing::kOffCentre_m + Vector3(0.02, -0.03, 0.02));
            device::Measurement last = run(device, 60);
            device.simulate_as(simulating(to));
            for (int k = 0; k < 200; ++k) {
                const device::Measurement state = device.advance(device::DeviceCommand::braking());
                for (std::size_t j = 0; j < 3; ++j) {
                    // Twice the speed of the hand's target, 0.8 m/s, is about 50 counts of a motor
                    // per tick.
                    EXPECT_LT(std::abs(state.counts[j] - last.counts[j]), 60)
                        << from.name << " to " << to.name << ", tick " << k;
                }
                last = state;
            }
        }
    }
}

TEST(PlantExchange, RestsWhereTheNewModelWouldRest) {
    // Without dry friction the rest position does not depend on history.
    const device::DeviceCommand push{Vector3(0.05, -0.04, 0.03), Vector3::Constant(1.5)};
    for (const PlantModel &from : kPlantModels) {
        for (const PlantModel &to : kPlantModels) {
            SimulationOptions before = simulating(from);
            SimulationOptions after = simulating(to);
            for (SimulationOptions *options : {&before, &after}) {
                options->effects.coulomb_friction = false;
                options->effects.winding_heat = false;
            }
            SimulatedPhantom changed(testing::phantom_1_0(), before, testing::kOffCentre_m);
            SimulatedPhantom fresh(testing::phantom_1_0(), after, testing::kOffCentre_m);
            run(changed, 300, push);
            changed.simulate_as(after);
            run(changed, 1500, push);
            run(fresh, 1800, push);
            EXPECT_LT((changed.truth().tip_m - fresh.truth().tip_m).norm(), 1e-7)
                << from.name << " to " << to.name;
            EXPECT_LT((changed.truth().current_A - fresh.truth().current_A).norm(), 1e-6);
        }
    }
}

TEST(PlantExchange, StopsDoNotEjectALinkageBeyondThem) {
    const device::DeviceDescription description = testing::phantom_1_0();
    const Vector3 within_rad(0.0, 0.7, 0.7 - 60.0 * std::numbers::pi / 180);
    const Vector3 beyond_rad(0.0, 0.7, 0.7 - 70.0 * std::numbers::pi / 180); // the fold limit is
                                                                             // 65°
    const Vector3 within_m = device::tip_position_m(description.geometry, within_rad);
    const Vector3 beyond_m = device::tip_position_m(description.geometry, beyond_rad);
    ASSERT_TRUE(device::can_reach(description, within_m));
    ASSERT_FALSE(device::can_reach(description, beyond_m));
    SimulatedPhantom device(description, simulating(kPlantModels.front()), beyond_m);
    run(device, 10);
    device.simulate_as(simulating(kPlantModels.back()));
    for (int k = 0; k < 500; ++k) {
        run(device, 1);
        // It only sags. A stop of 100 N·m/rad, compressed by 5°, would accelerate the motors to
        // more than 100 rad/s.
        ASSERT_LT(device.truth().theta_rate_rad_per_s.norm(), 10.0) << k;
    }
    device.set_hand_target(within_m);
    run(device, 1000);
    EXPECT_TRUE(device::can_reach(description, device.truth().tip_m));
    device.set_hand_target(beyond_m); // from inside the stops hold
    run(device, 1000);
    const Vector3 q_rad = device::joint_from_motor(description.geometry, device.truth().theta_rad);
    EXPECT_GT(q_rad[2] - q_rad[1], description.joint_limits.min_q3_minus_q2_rad - 0.02);
}

TEST(PlantExchange, InvalidOptionsAreRejectedAndChangeNothing) {
    SimulatedPhantom device(testing::phantom_1_0(), simulating(kPlantModels.back()),
                            testing::kOffCentre_m);
    SimulationOptions impossible = simulating(kPlantModels.back());
    impossible.dynamics = PlantDynamics::coupling; // and Coulomb friction
    EXPECT_THROW(device.simulate_as(impossible), InputError);
    impossible = simulating(kPlantModels.back());
    impossible.longest_step_s = 0.0;
    EXPECT_THROW(device.simulate_as(impossible), InputError);
    SimulatedPhantom twin(testing::phantom_1_0(), simulating(kPlantModels.back()),
                          testing::kOffCentre_m);
    device.set_hand_target(testing::kOffCentre_m + kSideways_m);
    twin.set_hand_target(testing::kOffCentre_m + kSideways_m);
    run(device, 100);
    run(twin, 100);
    EXPECT_EQ(device.truth().tip_m, twin.truth().tip_m);
}

TEST(PlantExchange, ADelaySetWhileItRunsShiftsTheCommand) {
    for (int delay = 0; delay <= 3; ++delay) {
        SimulationOptions options = simulating(kPlantModels.back());
        options.effects = PlantEffects::none();
        options.delay_periods = 1.0;
        SimulatedPhantom device(testing::phantom_1_0(), options, testing::kOffCentre_m);
        run(device, 10);
        options.delay_periods = delay;
        device.simulate_as(options);
        EXPECT_EQ(device.delay_periods(), delay);
        run(device, 5);
        device::DeviceCommand kick;
        kick.e_W_V = Vector3(1.0, 0.0, 0.0);
        int silent = 0;
        while (device.advance(kick).current_A[0] < 1e-4 && silent < 10) {
            ++silent;
        }
        EXPECT_EQ(silent, delay);
    }
}

TEST(PlantExchange, AHandSetWhileItHoldsIsAsStiffAsIfItHadHeldFromTheStart) {
    SimulationOptions options = simulating(kPlantModels.back());
    options.effects = PlantEffects::none();
    options.effects.gravity = true; // pulls the tip down by weight / stiffness
    const auto sag_m = [&](double changed_to_N_per_m, bool while_it_runs) {
        SimulationOptions before = options;
        before.hand.stiffness_N_per_m = while_it_runs ? 100.0 : changed_to_N_per_m;
        SimulatedPhantom device(testing::phantom_1_0(), before, testing::kOffCentre_m);
        run(device, 1000);
        before.hand.stiffness_N_per_m = changed_to_N_per_m;
        device.simulate_as(before);
        run(device, 6000);
        return (device.truth().tip_m - testing::kOffCentre_m).norm();
    };
    for (const double stiffness_N_per_m : {200.0, 400.0, 800.0}) {
        const double from_start_m = sag_m(stiffness_N_per_m, false);
        EXPECT_GT(from_start_m, 1e-4);
        EXPECT_NEAR(sag_m(stiffness_N_per_m, true), from_start_m, 1e-6);
    }
}

TEST(PlantExchange, APathFollowedWhileItRunsBeginsThen) {
    SimulatedPhantom device(testing::phantom_1_0(), simulating(kPlantModels.back()),
                            testing::kOffCentre_m);
    run(device, 300);
    device.follow(HandPath({{0.0, testing::kOffCentre_m},
                            {0.5, testing::kOffCentre_m + kSideways_m},
                            {0.6, testing::kOffCentre_m + kSideways_m}}));
    run(device, 250); // half of the way; a target is that of the middle of the last sub-step
    const auto target_m = [&] { return Vector3(device.truth().hand_target_m); };
    EXPECT_NEAR((target_m() - testing::kOffCentre_m).norm(), 0.5 * kSideways_m.norm(), 1e-5);
    run(device, 1000);
    EXPECT_NEAR((target_m() - testing::kOffCentre_m - kSideways_m).norm(), 0.0, 1e-12);
    device.set_hand_target(testing::kOffCentre_m);
    run(device, 1000);
    EXPECT_NEAR((target_m() - testing::kOffCentre_m).norm(), 0.0, 1e-6);
}

} // namespace
} // namespace springdrive::simulated
