// Covers the safety monitor's response to faults of the rendered force: amplifiers with a wrong
// gain or sign; windings whose R sags below R̂; late counts, so that a contact generates energy.
// The checks in every tick are listed in tests/support/fault_trial.h: the true force, too, is above
// its limit for at most one tick.
#include "tests/support/fault_trial.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <string>

namespace springdrive::servo {
namespace {

TEST(FaultInjection, TipForce) {
    RecordProperty("faults", testing::kFaultsOfACause);
    std::mt19937 random(41);
    int by_force = 0;
    for (int i = 0; i < testing::kFaultsOfACause && !HasFailure(); ++i) {
        testing::FaultTrial rig(testing::random_case(random, i, testing::Place::running_on_plate));
        SCOPED_TRACE(rig.what.description());
        // The device's own limit, or one that was lowered while no motor was driven.
        const double limit_N = i % 2 == 0 ? 8.5 : testing::uniform(random, 6.0, 8.0);
        rig.inputs.limits.tip_force_N = limit_N;
        rig.run_to_fault();
        const double force_N = rig.last.tip_force_N.norm();
        EXPECT_GT(force_N, 0.2);
        // An amplifier with excessive gain.
        const double gain = limit_N / force_N * testing::log_uniform(random, 1.1, 2.0);
        rig.commit(device::FaultKind::amplifier_gain, Vector3::Constant(gain));
        rig.run_to_trip(0.05);
        // If one tick exceeds both limits, the winding's is reported. An amplifier whose force
        // stays below contradicts its motor.
        const TripCause cause = rig.last.safety.cause;
        rig.expect_tripped_by(cause == TripCause::current || cause == TripCause::motor_contradicted
                                  ? cause
                                  : TripCause::tip_force);
        by_force += cause == TripCause::motor_contradicted ? 0 : 1;
        rig.expect_latched();
        rig.expect_reset_waits();
        rig.device().clear_fault();
        rig.inputs.limits = unlowered();
        rig.expect_recovery();
    }
    EXPECT_GT(by_force, testing::kFaultsOfACause / 2);
}

TEST(FaultInjection, Energy) {
    RecordProperty("faults", testing::kFaultsOfACause);
    std::mt19937 random(42);
    int by_energy = 0;
    for (int i = 0; i < testing::kFaultsOfACause && !HasFailure(); ++i) {
        testing::FaultCase what = testing::random_case(random, i, testing::Place::running_on_plate);
        what.firm = what.firm && what.tuning_name != "soft"; // it would hold even twice a soft
                                                             // spring
        what.target_m.y() = -testing::uniform(random, 1.0, 2.5) * (what.firm ? 1.5e-3 : 11e-3);
        testing::FaultTrial rig(what);
        SCOPED_TRACE(rig.what.description());
        rig.run_to_fault();
        rig.inputs.limits.generated_energy_J =
            0.03 * testing::log_uniform(random, 0.001, what.firm ? 0.3 : 1.0);
        // Reversed polarity: the force pulls in instead of pushing out, which contradicts the motor
        // within some 10 ms, if the energy is not above its limit before.
        rig.commit(device::FaultKind::amplifier_gain,
                   -Vector3::Ones() * testing::uniform(random, 1.0, 1.4));
        rig.run_to_trip(1.0);
        const TripCause cause = rig.last.safety.cause;
        rig.expect_tripped_by(cause == TripCause::motor_contradicted ? cause : TripCause::energy);
        by_energy += cause == TripCause::energy ? 1 : 0;
        rig.expect_latched();
        rig.expect_reset_waits();
        rig.device().clear_fault();
        rig.expect_recovery();
    }
    EXPECT_GT(by_energy, testing::kFaultsOfACause / 8);
}

/// A fault that may show in several ways, or not at all.
device::Fault some_fault(std::mt19937 &random, const testing::FaultCase &what) {
    switch (std::uniform_int_distribution<int>(0, 4)(random)) {
    case 0: // R falls to R̂, or below it
        return {device::FaultKind::sagging_winding,
                Vector3::Constant(what.tuning.dR_Ohm + testing::uniform(random, -0.1, 0.4))};
    case 1:
        return {device::FaultKind::sagging_winding,
                Vector3::Unit(static_cast<int>(random() % 3)) *
                    (what.tuning.dR_Ohm + testing::uniform(random, 0.0, 0.4))};
    case 2:
        return {device::FaultKind::late_counts,
                Vector3::Constant(
                    std::floor(what.servo_hz * testing::log_uniform(random, 0.002, 0.04)))};
    case 3: {
        Vector3 gain = Vector3::Ones();
        gain[static_cast<int>(random() % 3)] = -1.0;
        return {device::FaultKind::amplifier_gain, gain};
    }
    default:
        return {device::FaultKind::amplifier_gain,
                Vector3::Constant(testing::log_uniform(random, 1.2, 10.0))};
    }
}

TEST(FaultInjection, AnyCauseFirst) {
    constexpr int kAny = 2 * testing::kFaultsOfACause;
    RecordProperty("faults", kAny);
    std::mt19937 random(43);
    int tripped = 0;
    std::array<int, testing::kTripCauses> by_cause{};
    double max_N = 0.0;
    for (int i = 0; i < kAny && !HasFailure(); ++i) {
        testing::FaultTrial rig(testing::random_case(random, i, testing::Place::anywhere));
        SCOPED_TRACE(rig.what.description());
        rig.run_to_fault();
        const device::Fault fault = some_fault(random, rig.what);
        SCOPED_TRACE("fault " + std::to_string(static_cast<int>(fault.kind)) + " of " +
                     std::to_string(fault.size.maxCoeff()));
        rig.commit(fault.kind, fault.size);
        rig.run_to_trip(0.6);
        if (rig.has_tripped()) {
            ++tripped;
            ++by_cause[static_cast<std::size_t>(rig.last.safety.cause)];
            rig.expect_latched();
        }
        max_N = std::max(max_N, rig.max_force_N());
    }
    EXPECT_GT(tripped, kAny / 4);
    RecordProperty("tripped", tripped);
    for (std::size_t cause = 0; cause < by_cause.size(); ++cause) {
        RecordProperty(std::string(kTripCauseNames[cause]), by_cause[cause]);
    }
    RecordProperty("greatest_force_N", std::to_string(max_N));
}

} // namespace
} // namespace springdrive::servo
