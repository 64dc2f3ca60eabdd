// Covers the safety monitor's response to faults of host and operator, of measurements, of motion
// and of the rendered force. The checks in every tick are listed in tests/support/fault_trial.h:
// the true force, too, is above its limit for at most one tick.
#include "device/core/phantom/kinematics.h"
#include "tests/support/devices.h"
#include "tests/support/fault_trial.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::servo {
namespace {

using testing::Place;
using Rig = testing::FaultTrial;
using Random = std::mt19937;

/// Random cases at a place, up to the first failure: to each its number.
template <typename Expect> void for_each_case(unsigned seed, Place place, Expect &&expect) {
    ::testing::Test::RecordProperty("faults", testing::kFaultsOfACause);
    Random random(seed);
    for (int i = 0; i < testing::kFaultsOfACause && !::testing::Test::HasFailure(); ++i) {
        Rig rig(testing::random_case(random, i, place));
        SCOPED_TRACE(rig.what.description());
        expect(rig, random, i);
    }
}

/// Latched, and again after a reset, until `remove` removes the fault; then it starts after one.
template <typename Remove>
void expect_to_last(Rig &rig, TripCause cause, double within_s, Remove &&remove) {
    rig.expect_latched();
    rig.expect_reset_trips_again(cause, within_s);
    remove();
    rig.expect_latched();
    rig.expect_recovery();
}

TEST(FaultInjection, EmergencyStop) {
    for_each_case(11, Place::anywhere, [](Rig &rig, Random & /*random*/, int /*i*/) {
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
    });
}

TEST(FaultInjection, MissedDeadlines) {
    for_each_case(13, Place::anywhere, [](Rig &rig, Random &random, int /*i*/) {
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
        expect_to_last(rig, TripCause::missed_deadlines, 0.01, [&rig] { rig.timing = nullptr; });
    });
}

TEST(FaultInjection, WindowSilent) {
    for_each_case(14, Place::anywhere, [](Rig &rig, Random &random, int i) {
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
        expect_to_last(rig, TripCause::window_silent, limit_s + 0.01,
                       [&rig] { rig.window_responds = true; });
    });
}

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
    // A board is given a tenth of a second to clear its faults.
    expect_to_last(rig, cause, cause == TripCause::board_fault ? 0.11 : 0.01,
                   [&rig] { rig.device().clear_fault(); });
}

TEST(FaultInjection, DeviceLost) {
    for_each_case(21, Place::anywhere, [](Rig &rig, Random & /*random*/, int /*i*/) {
        see_through(rig, device::FaultKind::unplug, Vector3::Zero(), TripCause::device_lost);
    });
}

/// Missing, repeated or corrupt measurements are tolerated for the limit's time.
TEST(FaultInjection, StaleMeasurements) {
    for_each_case(24, Place::anywhere, [](Rig &rig, Random & /*random*/, int i) {
        constexpr std::array<device::FaultKind, 3> kKinds{
            device::FaultKind::drop, device::FaultKind::corrupt, device::FaultKind::repeat};
        rig.run_to_fault();
        rig.force_is_bounded = false; // the hand continues to move against a held e_W
        rig.commit(kKinds[static_cast<std::size_t>(i) % kKinds.size()], Vector3::Zero());
        const double budget_s = rig.device().description().limits.stale_s;
        rig.run_to_trip(budget_s + 2.0 / rig.what.servo_hz);
        rig.expect_tripped_by(TripCause::stale_measurement);
        rig.force_is_bounded = true;
        expect_to_last(rig, TripCause::stale_measurement, 0.01,
                       [&rig] { rig.device().clear_fault(); });
    });
}

TEST(FaultInjection, BoardFault) {
    for_each_case(25, Place::anywhere, [](Rig &rig, Random &random, int /*i*/) {
        // An amplifier's own fault opens the windings, where no brake bounds the hand.
        const double bits =
            static_cast<double>(2 * std::uniform_int_distribution<int>(1, 31)(random));
        see_through(rig, device::FaultKind::board, Vector3(bits, 0.0, 0.0), TripCause::board_fault);
    });
}

TEST(FaultInjection, NotFinite) {
    for_each_case(22, Place::anywhere, [](Rig &rig, Random &random, int /*i*/) {
        const double wrong_A = random() % 2 == 0 ? std::numeric_limits<double>::quiet_NaN()
                                                 : std::numeric_limits<double>::infinity();
        const Vector3 signs = some_motors(random);
        see_through(rig, device::FaultKind::current_reading,
                    (signs.array() == 0.0).select(0.0, wrong_A * signs), TripCause::not_finite);
    });
}

TEST(FaultInjection, CurrentReading) {
    for_each_case(23, Place::anywhere, [](Rig &rig, Random &random, int /*i*/) {
        const double peak_A = rig.device().description().motor[0].peak_current_A;
        const double read_A = peak_A * (1.0 + testing::log_uniform(random, 1e-4, 0.5));
        see_through(rig, device::FaultKind::current_reading, read_A * some_motors(random),
                    TripCause::current);
        EXPECT_DOUBLE_EQ(rig.inputs.limits.current_A, unlowered().current_A);
    });
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
    for_each_case(24, Place::anywhere, [](Rig &rig, Random &random, int i) {
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
    });
}

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
    for_each_case(33, Place::running_on_plate, [](Rig &rig, Random &random, int /*i*/) {
        rig.run_to_fault();
        // As if the motor were hotter: the remaining margin is exhausted soon.
        rig.inputs.limits.winding_C =
            rig.judge.upper_winding_C() + testing::uniform(random, -0.05, 0.05);
        rig.run_to_trip(2.0);
        rig.expect_tripped_by(TripCause::winding_temperature);
        EXPECT_LT(rig.truth().winding_C.maxCoeff(), rig.last.safety.limit);
        rig.inputs.limits.winding_C -= 0.5; // it cools while it brakes
        expect_to_last(rig, TripCause::winding_temperature, 0.01,
                       [&rig] { rig.inputs.limits = unlowered(); });
    });
}

TEST(FaultInjection, SustainedVoltage) {
    for_each_case(34, Place::running_on_plate, [](Rig &rig, Random &random, int /*i*/) {
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
    });
}

TEST(FaultInjection, TipForce) {
    int by_force = 0;
    for_each_case(41, Place::running_on_plate, [&](Rig &rig, Random &random, int i) {
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
        // stays below contradicts its motor: more than it is told drives a winding as if it
        // generated, so that R-hat falls.
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
    });
    EXPECT_GT(by_force, testing::kFaultsOfACause / 3);
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
