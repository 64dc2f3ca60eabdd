// Covers engine/lab/limits/impact.cpp and wall_tune.cpp: what drive_comparison.cpp compares. Its
// outputs are those of tests/app/tuning_commands_test.cpp.
#include "engine/lab/limits/drive_comparison.h"

#include "device/core/phantom/dynamics.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/coupling.h"
#include "engine/control/motion_control.h"
#include "engine/lab/limits/stability_simulation.h"
#include "engine/lab/loops/tip_stiffness.h"
#include "tests/support/devices.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>

namespace springdrive::limits {
namespace {

/// By a hand that continues at its speed.
loops::StabilityCase held_firmly(double period_s) {
    loops::StabilityCase which;
    which.device = testing::phantom_1_0();
    which.period_s = period_s;
    which.hands = {{"leading", 0.0, 200.0, 20000.0}};
    return which;
}

/// A wall of a current drive, a spring alone, with that resolution of the encoders.
loops::StabilityCase spring_wall(double period_s, int counts_per_turn) {
    loops::StabilityCase which = held_firmly(period_s);
    which.drive = device::AmplifierKind::current_drive;
    which.device.encoder_counts_per_turn = counts_per_turn;
    which.wall = {500.0, 0.0};
    return which;
}

/// A spring alone: the force grows by K times the displacement, so that rate over speed is K,
/// except for the initial lag of half a sample.
TEST(Impact, OfAPlainSpringIsItsStiffness) {
    const Impact found = impact(spring_wall(1e-4, testing::phantom_1_0().encoder_counts_per_turn));
    EXPECT_NEAR(found.rate_hardness_N_per_m, 500.0, 0.05 * 500.0);
    EXPECT_NEAR(found.max_force_N, 500.0 * 0.1 * 0.01, 0.1 * 0.5); // 10 ms at 0.1 m/s
}

/// A whole sample late, a tick sees the force of the tick before, which 1 to 10 ms after the
/// contact is by 10 % and more too small. Between ticks the force is that of the wall. A delay that
/// is part of a period postpones the force by as much: at a rate-hardness read within 10 ms, by a
/// share of d T/10 ms.
TEST(Impact, IsReadBetweenTicksTooAndFallsWithAnyDelay) {
    loops::StabilityCase which = spring_wall(1e-3, 1 << 20);
    const double at_once = impact(which).rate_hardness_N_per_m;
    EXPECT_NEAR(at_once, 500.0, 0.05 * 500.0);
    for (const double d : {0.5, 1.0, 2.5}) {
        which.delay_periods = d;
        EXPECT_NEAR(impact(which).rate_hardness_N_per_m / at_once, 1.0 - 0.1 * d, 0.03) << d;
    }
}

/// M with rotors, through J along the vertical: the mass of an unpowered current drive for a hand
/// that guides it along a line.
TEST(MeasuredMass, OfACurrentDriveIsTheLinkagesOwn) {
    loops::StabilityCase which = held_firmly(1e-4);
    which.drive = device::AmplifierKind::current_drive;
    const device::DeviceDescription &device = which.device;
    const device::LinkageMoments moments =
        device::linkage_moments(device.geometry, device.inertia, device.inertia.tip_load_kg);
    Matrix3 M = device::mass_matrix(moments, which.q_rad);
    for (Eigen::Index j = 0; j < 3; ++j) {
        const double N = device.geometry.transmission_ratio[j];
        M(j, j) += N * N * device.motor[0].rotor_inertia_kg_m2;
    }
    const Matrix3 J = device::joint_jacobian(device.geometry, which.q_rad);
    // Sideways the hand is stiff, so the tip keeps to the vertical: q̇ = J⁻¹ e_y ẏ.
    const Vector3 rate = J.inverse() * Vector3::UnitY();
    const double truth = rate.dot(M * rate);
    EXPECT_NEAR(apparent_mass_kg(which), truth, 0.03 * truth); // ±10 mm change M by a few per cent
}

/// k_T² τ/dR of each motor on top, τ the loop's whole lag (docs/design.md, "Contact and maps").
TEST(MeasuredMass, OfASpringDriveHasTheLagsToo) {
    const loops::StabilityCase which = held_firmly(1e-3);
    const double spring = apparent_mass_kg(which);
    loops::StabilityCase bare = which;
    bare.drive = device::AmplifierKind::current_drive;
    const double own = apparent_mass_kg(bare);
    const control::Coupling c =
        control::coupling(which.device.motor[0], which.tuning, which.period_s, 0);
    const Vector3 rate =
        device::motor_jacobian(which.device.geometry, which.q_rad).inverse() * Vector3::UnitY();
    const double truth = c.added_inertia_kg_m2 * rate.squaredNorm();
    EXPECT_NEAR(spring - own, truth, 0.05 * truth); // 5 Hz is not rest
}

constexpr double kMargin = 1.3;

loops::StabilityCase late_servo() {
    loops::StabilityCase which;
    which.device = testing::phantom_1_0();
    which.delay_periods = 1;
    which.hands = {loops::no_hand(), loops::hand_of_firmness(0.5)};
    return which;
}

loops::StabilityCase with(const TunedWall &tuned, double factor) {
    loops::StabilityCase which = late_servo();
    which.drive = device::AmplifierKind::current_drive;
    which.tuning.lambda_rad_per_s = tuned.lambda_rad_per_s;
    which.wall = {factor * tuned.wall.stiffness_N_per_m, factor * tuned.wall.damping_Ns_per_m};
    return which;
}

bool holds(loops::StabilityCase which) {
    which.freedom = loops::Freedom::one_motor;
    const bool each = loops::is_stable(which);
    which.freedom = loops::Freedom::three_motors;
    return each && loops::is_stable(which);
}

/// The stiffest, which the tests share.
const TunedWall &unlimited() {
    static const TunedWall tuned = tuned_wall(late_servo(), kMargin);
    return tuned;
}

TEST(TunedWall, LeavesItsMarginAndNoMore) {
    const TunedWall &tuned = unlimited();
    ASSERT_GT(tuned.wall.stiffness_N_per_m, 100.0);
    EXPECT_TRUE(holds(with(tuned, 1.0)));
    EXPECT_TRUE(holds(with(tuned, 0.999 * kMargin)));
    // With K alone a tenth larger the margin is lost: it is the largest with its B and λ.
    loops::StabilityCase stiffer = with(tuned, kMargin);
    stiffer.wall.stiffness_N_per_m *= 1.1;
    EXPECT_FALSE(holds(stiffer));
    EXPECT_TRUE(is_stable_simulated(with(tuned, 1.0),
                                    TrialOptions::with(SimulationEffects::electronics())));
}

/// Over an independent grid: no combination of K, B and λ exceeds it by more than the spacing of
/// its own grid.
TEST(TunedWall, IsTheStiffest) {
    const TunedWall &tuned = unlimited();
    for (int i = 0; i < 14; ++i) {
        const double B = std::pow(1.35, i); // up to 50
        for (int j = 0; j < 5; ++j) {
            const double lambda = 150.0 * std::pow(2.4, j); // up to 5000
            const TunedWall alternative{{1.06 * tuned.wall.stiffness_N_per_m, B}, lambda};
            EXPECT_FALSE(holds(with(alternative, kMargin))) << "B " << B << " λ " << lambda;
        }
    }
}

TEST(TunedWall, RespectsTheLimitOnTheForceOfACount) {
    const double large_N = loops::force_of_a_count_N(with(unlimited(), 1.0));
    const TunedWall quiet = tuned_wall(late_servo(), kMargin, 0.25 * large_N);
    ASSERT_GT(quiet.wall.stiffness_N_per_m, 0.0);
    EXPECT_LE(loops::force_of_a_count_N(with(quiet, 1.0)), 0.25 * large_N);
    EXPECT_TRUE(holds(with(quiet, kMargin)));
}

} // namespace
} // namespace springdrive::limits
