// Covers the safety monitor's response to excessive motion, heat and voltage: a hand that yanks,
// joints or encoders beyond the stops, a hot motor, a sustained request for more voltage. The
// checks in every tick are listed in tests/support/fault_trial.h.
#include "device/core/phantom/kinematics.h"
#include "tests/support/devices.h"
#include "tests/support/fault_trial.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::servo {
namespace {

/// The hand's path before the fault, and from then on with another speed and target.
simulated::SimulationOptions yanking(const testing::FaultCase &what, const Vector3 &end_m,
                                     double speed_m_per_s) {
    const double pull_s = static_cast<double>(what.at_tick) / what.servo_hz;
    const double goes_s = (what.target_m - what.start_m).norm() / what.hand_m_per_s;
    simulated::SimulationOptions options;
    options.path.emplace(std::vector<simulated::HandPath::Point>{
        {0.0, what.start_m},
        {0.3, what.start_m},
        {std::min(0.3 + goes_s, pull_s - 0.01), what.target_m},
        {pull_s, what.target_m},
        {pull_s + (end_m - what.target_m).norm() / speed_m_per_s, end_m}});
    return options;
}

TEST(FaultInjection, TipSpeed) {
    RecordProperty("faults", testing::kFaultsOfACause);
    std::mt19937 random(31);
    for (int i = 0; i < testing::kFaultsOfACause && !HasFailure(); ++i) {
        testing::FaultCase what = testing::random_case(random, i, testing::Place::anywhere);
        what.at_tick = std::max(what.at_tick, static_cast<std::uint64_t>(0.4 * what.servo_hz));
        what.start_m.x() = -0.06;
        what.target_m.x() = -0.055;
        const double device_limit = 2.0;
        const double limit =
            what.firm && i % 4 == 0 ? device_limit : testing::log_uniform(random, 0.2, 0.6);
        const double speed = std::min(limit * testing::uniform(random, 2.0, 3.0), 3.0);
        const Vector3 end_m(0.07, testing::uniform(random, 0.02, 0.05),
                            testing::uniform(random, -0.03, 0.03));
        testing::FaultTrial rig(what, yanking(what, end_m, speed));
        SCOPED_TRACE(rig.what.description() + ", then at " + std::to_string(speed) + " m/s");
        rig.run_to_fault();
        if (limit < device_limit) {
            rig.inputs.limits.tip_speed_m_per_s = limit;
        }
        // The filter follows the truth within a few of its time constants.
        const double late_s = 6.0 / what.tuning.lambda_rad_per_s + 2.0 / what.servo_hz;
        int above = 0;
        for (int tick = 0; tick < rig.ticks_in(0.5) && !rig.has_tripped(); ++tick) {
            rig.step();
            above = rig.truth().tip_velocity_m_per_s.norm() > 1.03 * limit ? above + 1 : 0;
            EXPECT_LE(above / what.servo_hz, late_s);
        }
        rig.expect_tripped_by(TripCause::tip_speed);
        // No false alarm, except by the count of an encoder, which a fast filter shows as speed.
        const device::DeviceDescription &device = rig.device().description();
        const double count_m_per_s = -std::expm1(-what.tuning.lambda_rad_per_s / what.servo_hz) *
                                     what.servo_hz * device.rad_per_count() /
                                     device.geometry.transmission_ratio[1] *
                                     device.geometry.upper_arm_m;
        EXPECT_GT(rig.truth().tip_velocity_m_per_s.norm(),
                  std::min(0.8 * limit, limit - count_m_per_s));
        rig.expect_latched();
        rig.inputs.limits = unlowered();
        for (int tick = 0; tick < rig.ticks_in(0.7); ++tick) { // until the hand has arrived
            rig.step();
        }
        rig.expect_recovery();
    }
}

/// Joint angles near one reachable stop, far from all others.
Vector3 angles_near(std::mt19937 &random, const device::JointLimits &stops, int stop) {
    constexpr double kOff_rad = 0.2;
    const double near_rad =
        testing::uniform(random, 0.1, 0.14); // beyond the soft wall's margin, 0.087
    while (true) {
        Vector3 q(testing::uniform(random, -0.7, 0.7), testing::uniform(random, -0.5, 1.9), 0.0);
        q[2] = q[1] + testing::uniform(random, -0.8, 0.7);
        if (stop < 2) {
            q[0] = stop == 0 ? stops.max_rad[0] - near_rad : stops.min_rad[0] + near_rad;
        } else if (stop == 2) {
            q[1] = stops.max_rad[1] - near_rad;
        } else if (stop == 3) {
            q[2] = stops.min_rad[2] + near_rad;
        } else {
            q[2] = q[1] + (stop == 4 ? stops.max_q3_minus_q2_rad - near_rad
                                     : stops.min_q3_minus_q2_rad + near_rad);
        }
        const std::array<double, 7> off{stops.max_rad[0] - q[0],
                                        q[0] - stops.min_rad[0],
                                        stops.max_rad[1] - q[1],
                                        q[2] - stops.min_rad[2],
                                        stops.max_q3_minus_q2_rad - (q[2] - q[1]),
                                        q[2] - q[1] - stops.min_q3_minus_q2_rad,
                                        stops.max_rad[2] - q[2]};
        bool alone = std::cos(q[1]) + std::sin(q[2]) > 0.4; // the base is not near its axis
        for (std::size_t other = 0; other < off.size(); ++other) {
            alone = alone && (static_cast<int>(other) == stop || off[other] > kOff_rad);
        }
        if (alone) {
            return q;
        }
    }
}

TEST(FaultInjection, BeyondStopsByDriftingCounts) {
    RecordProperty("faults", testing::kFaultsOfACause);
    std::mt19937 random(32);
    // Towards each stop: the joint that drifts, and its sign.
    constexpr std::array<std::pair<int, double>, 6> kTowards{
        {{0, 1.0}, {0, -1.0}, {1, 1.0}, {2, -1.0}, {2, 1.0}, {2, -1.0}}};
    for (int i = 0; i < testing::kFaultsOfACause && !HasFailure(); ++i) {
        testing::FaultCase what = testing::random_case(random, i, testing::Place::free);
        what.firm = true; // a light hand would yield to the soft wall
        const int stop = i % 6;
        const device::DeviceDescription device = testing::phantom_1_0();
        const Vector3 q_rad = angles_near(random, device.joint_limits, stop);
        what.start_m = device::tip_position_m(device.geometry, q_rad);
        what.target_m = what.start_m;
        testing::FaultTrial rig(what);
        SCOPED_TRACE(rig.what.description() + ", stop " + std::to_string(stop));
        if (i % 2 == 0) {
            rig.inputs.limits.beyond_stops_rad = testing::uniform(random, 0.002, 0.05);
        }
        rig.run_to_fault();
        const auto &[joint, sign] = kTowards[static_cast<std::size_t>(stop)];
        const double rate_rad_per_s = testing::uniform(random, 0.15, 0.35);
        const double counts_per_tick = rate_rad_per_s / what.servo_hz *
                                       device.geometry.transmission_ratio[joint] *
                                       device.encoder_counts_per_turn / (2.0 * std::numbers::pi);
        rig.commit(device::FaultKind::count_drift, sign * counts_per_tick * Vector3::Unit(joint));
        rig.run_to_trip(3.0);
        // A motor that is driven contradicts such counts before.
        const TripCause cause = rig.last.safety.cause;
        rig.expect_tripped_by(cause == TripCause::motor_contradicted ? cause
                                                                     : TripCause::beyond_stops);
        rig.expect_latched();
        EXPECT_FALSE(rig.device().is_zeroed());
        rig.expect_reset_waits();
        rig.device().clear_fault();
        rig.expect_recovery();
    }
}

TEST(FaultInjection, WindingTemperature) {
    RecordProperty("faults", testing::kFaultsOfACause);
    std::mt19937 random(33);
    for (int i = 0; i < testing::kFaultsOfACause && !HasFailure(); ++i) {
        testing::FaultTrial rig(testing::random_case(random, i, testing::Place::running_on_plate));
        SCOPED_TRACE(rig.what.description());
        rig.run_to_fault();
        // As if the motor were hotter: the remaining margin is exhausted soon.
        rig.inputs.limits.winding_C =
            rig.judge.upper_winding_C() + testing::uniform(random, -0.05, 0.05);
        rig.run_to_trip(2.0);
        rig.expect_tripped_by(TripCause::winding_temperature);
        EXPECT_LT(rig.truth().winding_C.maxCoeff(), rig.last.safety.limit);
        rig.inputs.limits.winding_C -= 0.5; // it cools while it brakes
        rig.expect_latched();
        rig.expect_reset_trips_again(TripCause::winding_temperature, 0.01);
        rig.inputs.limits = unlowered();
        rig.expect_latched();
        rig.expect_recovery();
    }
}

TEST(FaultInjection, SustainedVoltage) {
    RecordProperty("faults", testing::kFaultsOfACause);
    std::mt19937 random(34);
    for (int i = 0; i < testing::kFaultsOfACause && !HasFailure(); ++i) {
        testing::FaultTrial rig(testing::random_case(random, i, testing::Place::running_on_plate));
        SCOPED_TRACE(rig.what.description());
        rig.run_to_fault();
        // With stiff tunings a single tick may be far above the mean: a count moves e_W by 0.3 V.
        const int ticks = rig.ticks_in(0.05);
        Vector3 mean_V = Vector3::Zero();
        for (int tick = 0; tick < ticks; ++tick) {
            rig.step();
            mean_V += rig.last.command.e_W_V / ticks;
        }
        // A lowered limit is reached within a second.
        rig.inputs.limits.voltage_V =
            testing::uniform(random, 0.2, 0.8) * mean_V.cwiseAbs().maxCoeff();
        rig.run_to_trip(2.0);
        rig.expect_tripped_by(TripCause::voltage);
        rig.expect_latched();
        rig.expect_reset_waits();
        rig.inputs.limits = unlowered();
        rig.expect_recovery();
    }
}

} // namespace
} // namespace springdrive::servo
