// Covers engine/lab/limits/impact.cpp.
#include "engine/lab/limits/impact.h"

#include "device/core/phantom/dynamics.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/coupling.h"
#include "engine/control/motion_control.h"
#include "tests/support/devices.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

namespace springdrive::limits {
namespace {

loops::StabilityCase held_firmly() {
    loops::StabilityCase which;
    which.device = testing::phantom_1_0();
    which.period_s = 1e-4;
    which.hands = {{"leading", 0.0, 200.0, 20000.0}}; // continues at its speed
    return which;
}

/// A spring alone: the force grows by K times the displacement, so that rate over speed is K,
/// except for the initial lag of half a sample.
TEST(Impact, OfAPlainSpringIsItsStiffness) {
    loops::StabilityCase which = held_firmly();
    which.drive = device::AmplifierKind::current_drive;
    which.wall = {500.0, 0.0};
    const Impact found = impact(which);
    EXPECT_NEAR(found.rate_hardness_N_per_m, 500.0, 0.05 * 500.0);
    EXPECT_NEAR(found.max_force_N, 500.0 * 0.1 * 0.01, 0.1 * 0.5); // 10 ms at 0.1 m/s
}

/// A whole sample late, a tick sees the force of the tick before, which 1 to 10 ms after the
/// contact is by 10 % and more too small. Between ticks the force is that of the wall. With exact
/// angles.
TEST(Impact, IsReadBetweenTicksToo) {
    loops::StabilityCase which = held_firmly();
    which.drive = device::AmplifierKind::current_drive;
    which.device.encoder_counts_per_turn = 1 << 20;
    which.wall = {500.0, 0.0};
    which.period_s = 1e-3;
    EXPECT_NEAR(impact(which).rate_hardness_N_per_m, 500.0, 0.05 * 500.0);
}

/// A delay that is part of a period postpones the force by as much: at a rate-hardness read within
/// 10 ms, by a share of d T/10 ms.
TEST(Impact, FallsWithAnyDelay) {
    loops::StabilityCase which = held_firmly();
    which.drive = device::AmplifierKind::current_drive;
    which.device.encoder_counts_per_turn = 1 << 20;
    which.wall = {500.0, 0.0};
    which.period_s = 1e-3;
    const double at_once = impact(which).rate_hardness_N_per_m;
    for (const double d : {0.5, 1.0, 2.5}) {
        which.delay_periods = d;
        EXPECT_NEAR(impact(which).rate_hardness_N_per_m / at_once, 1.0 - 0.1 * d, 0.03) << d;
    }
}

TEST(Impact, GrowsWithTheWall) {
    loops::StabilityCase which = held_firmly();
    which.drive = device::AmplifierKind::current_drive;
    double before = 0.0;
    for (const double K : {200.0, 800.0, 3200.0}) {
        which.wall = {K, 0.0};
        const double found = impact(which).rate_hardness_N_per_m;
        EXPECT_GT(found, before);
        before = found;
    }
}

/// M with rotors, through J along the vertical: the mass of an unpowered current drive for a hand
/// that guides it along a line.
TEST(MeasuredMass, OfACurrentDriveIsTheLinkagesOwn) {
    loops::StabilityCase which = held_firmly();
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
    loops::StabilityCase which = held_firmly();
    which.period_s = 1e-3;
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

} // namespace
} // namespace springdrive::limits
