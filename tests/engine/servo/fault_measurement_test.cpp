// Covers the safety monitor's response to faults of measurements: a device that does not answer,
// values that are not finite, encoder jumps, currents beyond the amplifiers' limits. The checks in
// every tick are listed in tests/support/fault_trial.h.
#include "tests/support/fault_trial.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <numbers>
#include <random>

namespace springdrive::servo {
namespace {

/// One or several motors, each with −1, 0 or 1, not all zero.
Vector3 some_motors(std::mt19937 &random) {
    Vector3 signs = Vector3::Zero();
    while (signs.isZero()) {
        for (double &sign : signs) {
            sign = std::uniform_int_distribution<int>(-1, 1)(random);
        }
    }
    return signs;
}

/// A fault that is present immediately, and after each reset.
void see_through(testing::FaultTrial &rig, device::FaultKind kind, const Vector3 &size,
                 TripCause cause) {
    rig.run_to_fault();
    rig.commit(kind, size);
    rig.step();
    rig.expect_tripped_by(cause);
    rig.expect_latched();
    // A board is given a tenth of a second to clear its faults.
    rig.expect_reset_trips_again(cause, cause == TripCause::board_fault ? 0.11 : 0.01);
    rig.device().clear_fault();
    rig.expect_latched();
    rig.expect_recovery();
}

TEST(FaultInjection, DeviceLost) {
    RecordProperty("faults", testing::kFaultsOfACause);
    std::mt19937 random(21);
    for (int i = 0; i < testing::kFaultsOfACause && !HasFailure(); ++i) {
        testing::FaultTrial rig(testing::random_case(random, i, testing::Place::anywhere));
        SCOPED_TRACE(rig.what.description());
        see_through(rig, device::FaultKind::unplug, Vector3::Zero(), TripCause::device_lost);
    }
}

/// Missing, repeated or corrupt measurements are tolerated for the limit's time.
TEST(FaultInjection, StaleMeasurements) {
    RecordProperty("faults", testing::kFaultsOfACause);
    std::mt19937 random(24);
    for (int i = 0; i < testing::kFaultsOfACause && !HasFailure(); ++i) {
        testing::FaultTrial rig(testing::random_case(random, i, testing::Place::anywhere));
        SCOPED_TRACE(rig.what.description());
        constexpr std::array<device::FaultKind, 3> kKinds{
            device::FaultKind::drop, device::FaultKind::corrupt, device::FaultKind::repeat};
        rig.run_to_fault();
        rig.force_is_bounded = false; // the hand continues to move against a held e_W
        rig.commit(kKinds[static_cast<std::size_t>(i) % kKinds.size()], Vector3::Zero());
        const double budget_s = rig.device().description().limits.stale_s;
        rig.run_to_trip(budget_s + 2.0 / rig.what.servo_hz);
        rig.expect_tripped_by(TripCause::stale_measurement);
        rig.force_is_bounded = true;
        rig.expect_latched();
        rig.expect_reset_trips_again(TripCause::stale_measurement, 0.01);
        rig.device().clear_fault();
        rig.expect_latched();
        rig.expect_recovery();
    }
}

TEST(FaultInjection, BoardFault) {
    RecordProperty("faults", testing::kFaultsOfACause);
    std::mt19937 random(25);
    for (int i = 0; i < testing::kFaultsOfACause && !HasFailure(); ++i) {
        testing::FaultTrial rig(testing::random_case(random, i, testing::Place::anywhere));
        SCOPED_TRACE(rig.what.description());
        // An amplifier's own fault opens the windings, where no brake bounds the hand.
        const double bits =
            static_cast<double>(2 * std::uniform_int_distribution<int>(1, 31)(random));
        see_through(rig, device::FaultKind::board, Vector3(bits, 0.0, 0.0), TripCause::board_fault);
    }
}

TEST(FaultInjection, NotFinite) {
    RecordProperty("faults", testing::kFaultsOfACause);
    std::mt19937 random(22);
    for (int i = 0; i < testing::kFaultsOfACause && !HasFailure(); ++i) {
        testing::FaultTrial rig(testing::random_case(random, i, testing::Place::anywhere));
        SCOPED_TRACE(rig.what.description());
        const double wrong_A = random() % 2 == 0 ? std::numeric_limits<double>::quiet_NaN()
                                                 : std::numeric_limits<double>::infinity();
        const Vector3 signs = some_motors(random);
        see_through(rig, device::FaultKind::current_reading,
                    (signs.array() == 0.0).select(0.0, wrong_A * signs), TripCause::not_finite);
    }
}

TEST(FaultInjection, CurrentReading) {
    RecordProperty("faults", testing::kFaultsOfACause);
    std::mt19937 random(23);
    for (int i = 0; i < testing::kFaultsOfACause && !HasFailure(); ++i) {
        testing::FaultTrial rig(testing::random_case(random, i, testing::Place::anywhere));
        SCOPED_TRACE(rig.what.description());
        const double peak_A = rig.device().description().motor[0].peak_current_A;
        const double read_A = peak_A * (1.0 + testing::log_uniform(random, 1e-4, 0.5));
        see_through(rig, device::FaultKind::current_reading, read_A * some_motors(random),
                    TripCause::current);
        EXPECT_DOUBLE_EQ(rig.inputs.limits.current_A, unlowered().current_A);
    }
}

/// Counts that move the tip by a given distance, with motor directions as in `signs`.
Vector3 jump_counts(const testing::FaultTrial &rig, const Vector3 &signs, double way_m) {
    const device::DeviceDescription &device = rig.device().description();
    const testing::TipAt now(device.geometry, rig.truth().theta_rad);
    const double tip_m_per_count =
        (now.J * signs).norm() * 2.0 * std::numbers::pi / device.encoder_counts_per_turn;
    return (signs * (way_m / tip_m_per_count)).array().round();
}

/// More than a tip at twice its maximum speed moves in a tick, plus five counts.
double surely_a_jump_m(const testing::FaultTrial &rig) {
    const device::DeviceDescription &device = rig.device().description();
    const testing::TipAt now(device.geometry, rig.truth().theta_rad);
    return 2.0 * device.limits.tip_speed_m_per_s / rig.what.servo_hz +
           5.0 * now.J.norm() * 2.0 * std::numbers::pi / device.encoder_counts_per_turn;
}

TEST(FaultInjection, EncoderJump) {
    RecordProperty("faults", testing::kFaultsOfACause);
    std::mt19937 random(24);
    for (int i = 0; i < testing::kFaultsOfACause && !HasFailure(); ++i) {
        testing::FaultTrial rig(testing::random_case(random, i, testing::Place::anywhere));
        SCOPED_TRACE(rig.what.description());
        rig.run_to_fault();
        const double way_m = testing::log_uniform(random, 1.3 * surely_a_jump_m(rig), 0.06);
        const bool flickers = i % 2 == 0;
        rig.commit(flickers ? device::FaultKind::count_flicker : device::FaultKind::count_step,
                   jump_counts(rig, some_motors(random), way_m));
        rig.step();
        rig.expect_tripped_by(TripCause::encoder_jump);
        EXPECT_NEAR(rig.last.safety.measured, way_m, 0.5 * way_m);
        rig.expect_latched();
        EXPECT_FALSE(rig.device().is_zeroed());
        rig.expect_reset_waits(); // an offset that stays looks like any other position
        rig.device().clear_fault();
        rig.expect_recovery();
    }
}

} // namespace
} // namespace springdrive::servo
