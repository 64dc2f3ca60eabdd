// Covers device/simulated/simulated_phantom.cpp and plant_setup.cpp.
#include "device/simulated/simulated_phantom.h"

#include "base/input_error.h"
#include "device/phantom/kinematics.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace springdrive {
namespace {

const Vector3 kStart_m(0.02, 0.03, 0.01);

DeviceCommand voltage(const Vector3 &e_W_V, double R_hat_Ohm) {
    return {e_W_V, Vector3::Constant(R_hat_Ohm)};
}

/// Rigid links, rotors, windings and encoders alone.
SimulationOptions bare() {
    SimulationOptions options;
    options.effects = PlantEffects::none();
    return options;
}

/// Held as in a vice.
SimulationOptions held() {
    SimulationOptions options = bare();
    options.hand = {1e6, 1e6, 1e9, 1e9, 1.0};
    return options;
}

TEST(SimulatedPhantom, StaysAtRestWhereItStarts) {
    SimulatedPhantom device(testing::phantom_1_0(), bare(), kStart_m);
    const DeviceState first = device.exchange(DeviceCommand::braking());
    for (int i = 0; i < 2000; ++i) {
        EXPECT_EQ(device.exchange(DeviceCommand::braking()).counts, first.counts);
    }
    EXPECT_LT((device.truth().tip_m - kStart_m).norm(), 1e-12);
}

TEST(SimulatedPhantom, AHeldRotorRendersTheSeriesSpringAndDamper) {
    // A hand as stiff as a vice holds the tip: the motor sees θ̇ = 0, and (11) is a plain RL
    // circuit with the closed form i = e_W/dR (1 − e^(−dR t/L)).
    SimulatedPhantom device(testing::phantom_1_0(), held(), kStart_m);
    const double dR = 0.3;
    const MotorParameters &m = device.description().motor[0];
    const DeviceCommand command = voltage(Vector3(0.1, -0.05, 0.02), m.resistance_Ohm - dR);
    for (int k = 1; k <= 10; ++k) {
        const DeviceState state = device.exchange(command);
        const Vector3 expected =
            command.e_W_V / dR * (1.0 - std::exp(-dR * k * 1e-3 / m.inductance_H));
        // The vice gives by 1 µm per kN; what is left of k_T θ̇ is below 1e-7 of e_W.
        EXPECT_LT((state.current_A - expected).norm(), 1e-6 * expected.norm());
    }
}

TEST(SimulatedPhantom, AnOverCancelledWindingGrowsAsItShould) {
    // dR < 0 (DESIGN section 6): the current grows as e^(|dR| t/L) until the rail.
    SimulationOptions options = held();
    options.effects.amplifier_limits = true;
    SimulatedPhantom device(testing::phantom_1_0(), options, kStart_m);
    const MotorParameters &m = device.description().motor[0];
    const double dR = -0.1;
    const DeviceCommand command = voltage(Vector3(1e-3, 0.0, 0.0), m.resistance_Ohm - dR);
    double before = 0.0;
    for (int k = 1; k <= 8; ++k) {
        const double current = device.exchange(command).current_A[0];
        EXPECT_NEAR(current, 1e-3 / dR * (1.0 - std::exp(-dR * k * 1e-3 / m.inductance_H)),
                    1e-6 * current);
        EXPECT_GT(current, before);
        before = current;
    }
    for (int k = 0; k < 200; ++k) {
        before = device.exchange(command).current_A[0];
    }
    // On the rail the winding sees the supply through its whole resistance.
    EXPECT_LE(before, m.supply_V / m.resistance_Ohm * (1.0 + 1e-9));
    EXPECT_GT(before, 0.9 * m.supply_V / m.resistance_Ohm);
}

TEST(SimulatedPhantom, ConvergesAtSecondOrder) {
    const auto final_tip = [](double step_s) {
        SimulationOptions options = bare();
        options.longest_step_s = step_s;
        SimulatedPhantom device(testing::phantom_1_0(), options, kStart_m);
        for (int k = 0; k < 40; ++k) {
            device.exchange(voltage(Vector3(0.4, -0.3, 0.2) * std::sin(0.3 * k), 1.6));
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
    SimulatedPhantom device(testing::phantom_1_0(), {}, kStart_m);
    device.set_hand_target(kStart_m + Vector3(0.02, -0.03, 0.02));
    for (int k = 0; k < 500; ++k) {
        const DeviceState state = device.exchange(DeviceCommand::braking());
        const double rad_per_count = 2.0 * std::numbers::pi / 4096;
        for (int j = 0; j < 3; ++j) {
            ASSERT_LE(std::abs(state.counts[static_cast<std::size_t>(j)] * rad_per_count -
                               device.truth().theta_rad[j]),
                      0.5 * rad_per_count + 1e-12);
        }
    }
    EXPECT_GT((device.truth().tip_m - kStart_m).norm(), 0.01); // it did move
}

TEST(SimulatedPhantom, ADelayShiftsTheCommandByWholeSamples) {
    for (int delay = 0; delay <= 3; ++delay) {
        SimulationOptions options = bare();
        options.delay_periods = delay;
        SimulatedPhantom device(testing::phantom_1_0(), options, kStart_m);
        const DeviceCommand kick = voltage(Vector3(1.0, 0.0, 0.0), 1.0);
        int silent = 0;
        while (device.exchange(kick).current_A[0] < 1e-9) { // round-off of the rest at the start
            ++silent;
        }
        EXPECT_EQ(silent, delay);
        EXPECT_EQ(device.delay_periods(), delay);
    }
}

TEST(SimulatedPhantom, AHandPushesNoHarderThanItCan) {
    SimulationOptions options;
    SimulatedPhantom device(testing::phantom_1_0(), options, kStart_m);
    // Shorted windings brake, the target runs away at its greatest speed.
    device.set_hand_target(kStart_m + Vector3(0.5, 0.0, 0.0));
    const double greatest = options.hand.greatest_force_N + 2.0 * options.hand.damping_Ns_per_m *
                                                                options.hand.greatest_speed_m_per_s;
    for (int k = 0; k < 300; ++k) {
        device.exchange(DeviceCommand::braking());
        ASSERT_LT(device.truth().hand_force_N.norm(), greatest);
    }
}

TEST(SimulatedPhantom, ACommandThatIsNotFiniteBrakes) {
    SimulatedPhantom device(testing::phantom_1_0(), bare(), kStart_m);
    device.exchange(voltage(Vector3(NAN, 1.0, INFINITY), 1.0));
    EXPECT_LT(device.truth().current_A.norm(), 1e-12); // round-off of the rest at the start
    EXPECT_TRUE(device.truth().tip_m.allFinite());
}

TEST(SimulatedPhantom, RefusesAStartOutOfReachAndADelayThatIsNone) {
    const DeviceDescription description = testing::phantom_1_0();
    EXPECT_THROW(SimulatedPhantom(description, {}, Vector3(1.0, 0.0, 0.0)), InputError);
    // Within reach, but the links fold further than their stops allow: 70° in place of 65°.
    const Vector3 folded_m = tip_position_m(description.geometry,
                                            Vector3(0.0, 0.7, 0.7 - 70.0 * std::numbers::pi / 180));
    EXPECT_THROW(SimulatedPhantom(description, {}, folded_m), InputError);
    SimulationOptions options = bare();
    EXPECT_NO_THROW(SimulatedPhantom(description, options, folded_m));
    options.delay_periods = -1;
    EXPECT_THROW(SimulatedPhantom(description, options, kStart_m), InputError);
    options.delay_periods = SimulationOptions::kLongestDelay + 1;
    EXPECT_THROW(SimulatedPhantom(description, options, kStart_m), InputError);
}

} // namespace
} // namespace springdrive
