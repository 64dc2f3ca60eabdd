// Covers what a board does where a winding generates (device/usb/board/loop_parts.h, Balances): by
// the true currents of exact windings, and of the simulated plant behind an emulated board.
#include "tests/device/usb/board_rig.h"
#include "tests/support/cases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>
#include <string>

namespace springdrive::board {
namespace {

using testing::BoardRig;
using testing::drive;
using testing::DrivingRig;
using usb::Faults;

/// For how long a current has been above 0.17 A with one sign.
class Above {
public:
    double update(double current_A, double step_s) {
        above_s_ =
            std::abs(current_A) > 0.17 && current_A * before_A_ > 0.0 ? above_s_ + step_s : 0.0;
        before_A_ = current_A;
        return above_s_;
    }

private:
    double above_s_ = 0.0;
    double before_A_ = 0.0;
};

TEST(BoardBalance, BrakesAWindingThatGeneratesBelowThePeakWithinThreeMilliseconds) {
    constexpr double kLoop_s = 25e-6;
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> any(0.0, 1.0);
    const int runs = testing::cases(60, 3000);
    double largest_A = 0.0;
    double longest_s = 0.0;
    for (int run = 0; run < runs; ++run) {
        SCOPED_TRACE("run " + std::to_string(run));
        DrivingRig rig;
        const std::size_t j = static_cast<std::size_t>(run) % 3;
        testing::RigMotor &motor = rig.motor[j];
        motor.is_held = any(random) < 0.5;
        motor.sensor_gain = 1.0 + 0.01 * (2.0 * any(random) - 1.0);
        motor.inductance_H *= 0.8 + 0.4 * any(random);
        rig.command = drive(0.0F, 1.68F);
        rig.command.e_W_V[j] = static_cast<float>(0.5 * (2.0 * any(random) - 1.0));
        rig.run_ms(3);
        ASSERT_EQ(rig.faults(), 0);
        motor.resistance_Ohm = 1.68 * motor.sensor_gain - 0.3;
        Above above;
        for (int loop = 0; loop < 4000 && rig.faults() == 0; ++loop) {
            rig.run_loops(1);
            largest_A = std::max(largest_A, std::abs(motor.current_A));
            longest_s = std::max(longest_s, above.update(motor.current_A, kLoop_s));
            ASSERT_LE(longest_s, 3e-3);
        }
        ASSERT_EQ(rig.faults(), Faults::kGenerating);
        EXPECT_EQ(rig.state(), State::fault_braking);
        EXPECT_TRUE(testing::all_stages(rig.order, Stage::brake));
        rig.run_ms(2);
        EXPECT_EQ(rig.report.faults, Faults::kGenerating);
    }
    EXPECT_LT(largest_A, 5.5);
    std::printf("largest of %d: %.2f A; found after at most %.2f ms\n", runs, largest_A,
                1e3 * longest_s);
}

// Until the host resets the fault; if nothing has changed, it comes again.
TEST(BoardBalance, LatchesUntilAReset) {
    DrivingRig rig;
    rig.motor[1].resistance_Ohm = 1.38;
    rig.run_ms(20);
    ASSERT_EQ(rig.faults(), Faults::kGenerating);
    rig.run_ms(20);
    EXPECT_EQ(rig.state(), State::fault_braking);
    for (const double R_Ohm : {1.38, 2.18}) {
        rig.motor[1].resistance_Ohm = R_Ohm;
        rig.command = testing::mode(usb::Mode::brake);
        rig.command.resets_faults = true;
        rig.run_ms(3);
        EXPECT_EQ(rig.faults(), 0);
        rig.command = drive();
        rig.run_ms(20);
        EXPECT_EQ(rig.faults() != 0, R_Ohm < 1.68) << R_Ohm;
    }
}

// Currents and speeds of hands that let go, with what a board does not know of its motors.
TEST(BoardBalance, LetsHealthyWindingsAlone) {
    std::mt19937_64 random(4);
    std::uniform_real_distribution<double> any(0.0, 1.0);
    std::normal_distribution<double> noise(0.0, 0.003);
    const int runs = testing::cases(20, 2000);
    for (int run = 0; run < runs; ++run) {
        SCOPED_TRACE("run " + std::to_string(run));
        DrivingRig rig;
        for (testing::RigMotor &motor : rig.motor) {
            motor.sensor_gain = 1.0 + 0.01 * (2.0 * any(random) - 1.0);
            motor.torque_constant_Nm_per_A *= 0.97 + 0.06 * any(random);
            motor.inductance_H *= 0.8 + 0.4 * any(random);
            motor.is_held = any(random) < 0.3;
            motor.resistance_Ohm = 1.68 * motor.sensor_gain + 2.18 * std::pow(0.02, any(random));
        }
        rig.tamper = [&](Samples &samples) {
            for (float &current_A : samples.current_A) {
                current_A = static_cast<float>(
                    std::round((static_cast<double>(current_A) + noise(random)) / 0.0039) * 0.0039);
            }
        };
        for (int ms = 0; ms < 300; ++ms) {
            for (std::size_t i = 0; i < 3; ++i) {
                if (any(random) < 0.05) {
                    const double dR_Ohm = rig.motor[i].resistance_Ohm - 1.68;
                    rig.command.e_W_V[i] =
                        static_cast<float>(4.0 * (2.0 * any(random) - 1.0) *
                                           (rig.motor[i].is_held ? dR_Ohm : 0.5 * any(random)));
                }
                rig.motor[i].rate_rad_per_s =
                    std::clamp(rig.motor[i].rate_rad_per_s, -100.0, 100.0);
            }
            rig.run_ms(1);
            ASSERT_EQ(rig.faults(), 0) << "after " << ms << " ms";
        }
    }
}

// A motor whose R is 0.3 Ω below R̂, pressed against a hand, with all that the plant has.
TEST(BoardBalance, StopsTheSimulatedPlantBelowItsPeak) {
    for (const double e_W_V : {-0.3, -0.1, 0.1, 0.3}) {
        emulator::EmulatedBoardOptions with = testing::emulated_options();
        with.simulation.resistance_share = Vector3(1.0, 1.38 / 2.18, 1.0);
        testing::Host host(with);
        host.begin(40);
        double largest_A = 0.0;
        int above = 0; // reports
        int found = 0;
        for (int ms = 0; ms < 200 && host.faults() == 0; ++ms) {
            host.exchange(testing::driving(Vector3(0.0, e_W_V, 0.0)));
            const double current_A = std::abs(host.board.plant().phantom().truth().current_A[1]);
            largest_A = std::max(largest_A, current_A);
            above = current_A > 0.17 ? above + 1 : 0;
            found = std::max(found, above);
        }
        EXPECT_EQ(host.faults(), Faults::kGenerating) << e_W_V;
        EXPECT_LE(found, 3) << e_W_V;
        EXPECT_LT(largest_A, 5.5) << e_W_V;
    }
}

} // namespace
} // namespace springdrive::board
