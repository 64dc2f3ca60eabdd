// Covers the safety monitor's response to faults of host and operator: the emergency stop, missed
// deadlines and a window without heartbeat. The checks in every tick are listed in
// tests/support/fault_trial.h.
#include "tests/support/fault_trial.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace springdrive::servo {
namespace {

TEST(FaultInjection, EmergencyStop) {
    RecordProperty("faults", testing::kFaultsOfACause);
    std::mt19937 random(11);
    for (int i = 0; i < testing::kFaultsOfACause && !HasFailure(); ++i) {
        testing::FaultTrial rig(testing::random_case(random, i, testing::Place::anywhere));
        SCOPED_TRACE(rig.what.description());
        rig.run_to_fault();
        rig.inputs.requested_stop = 1;
        rig.step();
        rig.expect_tripped_by(TripCause::emergency_stop);
        rig.expect_latched();
        rig.reset(); // without effect
        rig.expect_latched();
        rig.inputs.released_stop = 1;
        rig.expect_latched();
        rig.expect_recovery();
    }
}

TEST(FaultInjection, MissedDeadlines) {
    RecordProperty("faults", testing::kFaultsOfACause);
    std::mt19937 random(13);
    for (int i = 0; i < testing::kFaultsOfACause && !HasFailure(); ++i) {
        testing::FaultTrial rig(testing::random_case(random, i, testing::Place::anywhere));
        SCOPED_TRACE(rig.what.description());
        rig.run_to_fault();
        rig.force_is_bounded = false; // the servo is not running to bound it
        const double maximum = testing::log_uniform(random, 1.0, 70.0);
        std::uint32_t in_a_row = 0;
        rig.timing = [&] {
            const auto missed =
                static_cast<std::uint32_t>(testing::uniform(random, 1.0, maximum + 1.0));
            rig.device().pass_by(static_cast<int>(missed));
            in_a_row += missed;
            return TickTiming{missed, in_a_row};
        };
        rig.run_to_trip(0.1);
        rig.expect_tripped_by(TripCause::missed_deadlines);
        EXPECT_NEAR(rig.last.safety.measured, in_a_row / rig.what.servo_hz, 1e-9);
        rig.force_is_bounded = true;
        rig.expect_latched();
        rig.expect_reset_trips_again(TripCause::missed_deadlines, 0.01);
        rig.timing = nullptr;
        rig.expect_latched();
        rig.expect_recovery();
    }
}

TEST(FaultInjection, WindowSilent) {
    RecordProperty("faults", testing::kFaultsOfACause);
    std::mt19937 random(14);
    for (int i = 0; i < testing::kFaultsOfACause && !HasFailure(); ++i) {
        testing::FaultTrial rig(testing::random_case(random, i, testing::Place::anywhere));
        SCOPED_TRACE(rig.what.description());
        const double limit_s = i % 6 == 0 ? 2.0 : testing::log_uniform(random, 0.05, 1.0);
        rig.inputs.limits.window_silence_s = limit_s;
        rig.run_to_fault();
        rig.window_responds = false;
        const std::uint32_t last_beat = rig.inputs.heartbeat;
        rig.run_to_trip(limit_s - 0.02); // the last heartbeat was at most 16 ms ago
        EXPECT_FALSE(rig.has_tripped());
        rig.run_to_trip(0.03);
        EXPECT_EQ(rig.inputs.heartbeat, last_beat);
        rig.expect_tripped_by(TripCause::window_silent);
        rig.expect_latched();
        rig.expect_reset_trips_again(TripCause::window_silent, limit_s + 0.01);
        rig.window_responds = true;
        rig.expect_latched();
        rig.expect_recovery();
    }
}

} // namespace
} // namespace springdrive::servo
