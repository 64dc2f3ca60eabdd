#include "tests/support/fault_trial.h"
#include "tests/support/devices.h"
#include "tests/support/surfaces.h"
#include "tests/support/tunings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <sstream>

namespace springdrive::testing {

double uniform(std::mt19937 &random, double minimum, double maximum) {
    return std::uniform_real_distribution<double>(minimum, maximum)(random);
}

double log_uniform(std::mt19937 &random, double minimum, double maximum) {
    return std::exp(uniform(random, std::log(minimum), std::log(maximum)));
}

device::HandParameters FaultCase::hand() const {
    device::HandParameters hand = firm ? kFirmHand : kLightHand;
    hand.max_speed_m_per_s = hand_m_per_s;
    return hand;
}

std::string FaultCase::description() const {
    std::ostringstream text;
    text << tuning_name << " at " << servo_hz << " Hz, " << (firm ? "firm" : "light")
         << " hand from (" << start_m.transpose() << ") to (" << target_m.transpose() << ") at "
         << hand_m_per_s << " m/s, fault in tick " << at_tick;
    return text.str();
}

FaultCase random_case(std::mt19937 &random, int number, Place place) {
    FaultCase what;
    what.servo_hz = number % 12 == 7 ? 10'000.0 : (number / 3 % 2 == 0 ? 1000.0 : 4000.0);
    const std::array<std::string, 3> tunings{
        "firm", "soft", what.servo_hz < 4000.0 ? "stable_only_1kHz" : "stable_only_4kHz"};
    what.tuning_name = tunings[static_cast<std::size_t>(number % 3)];
    what.tuning = tuning(what.tuning_name);
    what.firm = number / 6 % 2 == 0;
    what.on_plate = place == Place::plate || place == Place::running_on_plate ||
                    (place == Place::anywhere && number / 12 % 2 == 0);
    const auto across = [&] { return uniform(random, -0.04, 0.04); };
    what.start_m = {across(), uniform(random, 0.012, 0.03), across()};
    what.target_m = {across(), uniform(random, 0.012, 0.03), across()};
    what.hand_m_per_s = log_uniform(random, 0.05, 0.4);
    if (what.on_plate) { // pressing with 1 N to 4 N on about 1.5 N/mm
        what.target_m = what.start_m + Vector3(0.005, 0.0, -0.003);
        what.target_m.y() = -uniform(random, 1.0, 2.5) * (what.firm ? 1.5e-3 : 11e-3);
        what.hand_m_per_s = log_uniform(random, 0.12, 0.4);
    }
    double earliest_s = what.on_plate ? 0.85 : 0.02;
    if (place == Place::running_free || place == Place::running_on_plate) {
        earliest_s = 1.15;
    }
    what.at_tick =
        static_cast<std::uint64_t>(what.servo_hz * uniform(random, earliest_s, 1.45)) + 2;
    return what;
}

namespace {

constexpr double kHandGoes_s = 0.35; // from rest
constexpr int kLatched_ticks = 200;
constexpr double kForceRoundOff = 2e-3; // of encoder counts relative to the true angles
constexpr double kHeartbeat_s = 0.016;

simulated::SimulationOptions at_rate_with_hand(const FaultCase &what,
                                               simulated::SimulationOptions options, HandOf hand) {
    options.servo_period_s = 1.0 / what.servo_hz;
    if (hand == HandOf::fault_case) {
        options.hand = what.hand();
    }
    return options;
}

bool says_no_numbers(servo::TripCause cause) {
    return cause == servo::TripCause::emergency_stop || cause == servo::TripCause::device_lost ||
           cause == servo::TripCause::not_finite;
}

} // namespace

FaultTrial::FaultTrial(const FaultCase &fault_case, const simulated::SimulationOptions &options,
                       HandOf hand)
    : ServoRig(phantom_1_0(), at_rate_with_hand(fault_case, options, hand), fault_case.start_m),
      what(fault_case), judge(device().description(), 1.0 / fault_case.servo_hz),
      plate_(box_soup(Vector3(-0.1, -0.04, -0.1), Vector3(0.1, 0.0, 0.1))) {
    inputs.tuning = what.tuning;
    inputs.surface = what.on_plate ? &plate_ : nullptr;
    inputs.heartbeat = 1;
}

int FaultTrial::ticks_in(double time_s) const {
    return static_cast<int>(std::lround(time_s * what.servo_hz));
}

servo::ServoSample FaultTrial::step() {
    if (ticks_ == static_cast<std::uint64_t>(ticks_in(kHandGoes_s))) {
        phantom().set_hand_target(what.target_m);
    }
    if (window_responds && ticks_ % static_cast<std::uint64_t>(ticks_in(kHeartbeat_s)) == 0) {
        ++inputs.heartbeat;
    }
    const servo::TickTiming now = timing ? timing() : servo::TickTiming{};
    const bool was_tripped = has_tripped();
    tick(now);
    judge.look(measured(), inputs, now, last);
    check(measured());
    if (has_tripped() && (!was_tripped || since_reset_ == 0)) {
        check_trip();
    }
    ++ticks_;
    ++since_reset_;
    return last;
}

void FaultTrial::check(const device::Measurement &measured) {
    EXPECT_EQ(last.tick, ticks_);
    EXPECT_EQ(device().periods(), ticks_ + 1);
    EXPECT_EQ(last.counts, measured.counts);
    EXPECT_EQ(device().last_command().e_W_V, last.command.e_W_V);
    EXPECT_EQ(device().last_command().cancelled_resistance_Ohm,
              last.command.cancelled_resistance_Ohm);
    EXPECT_EQ(device().last_command().mode, last.command.mode);
    EXPECT_EQ(device().last_command().number, measured.number);
    EXPECT_TRUE(last.command.e_W_V.allFinite());
    check_force();
    if (has_tripped() || !device().is_zeroed()) {
        late_ = 0;
        check_braking();
    } else if (late_ > 0 || judge.first_must() != servo::TripCause::none) {
        max_ticks_late_ = std::max(max_ticks_late_, ++late_);
        EXPECT_LE(late_, 0) << "no trip in tick " << ticks_ << " by "
                            << servo::kTripCauseNames[static_cast<std::size_t>(judge.first_must())];
    }
    if (judge.generated_J() != 0.0 && last.safety.state == servo::SafetyState::running) {
        EXPECT_NEAR(last.generated_energy_J, judge.generated_J(), 1e-3 * 0.03);
    }
    recent_.emplace_back(last.tip_m, last.contact.touching);
    if (recent_.size() > static_cast<std::size_t>(ticks_in(0.1))) {
        recent_.pop_front();
    }
}

/// Checks the true force of the true currents at the end of every tick. After a trip it is at most
/// what a shorted winding retains, e^(−T R/L) per tick, plus its response to the hand's speed.
void FaultTrial::check_force() {
    const device::DeviceDescription &device_of = device().description();
    const TipAt tip(device_of.geometry, truth().theta_rad);
    const Vector3 k_T = control::torque_constants(device_of);
    const double force_N = tip.force_N(k_T.cwiseProduct(truth().current_A)).norm();
    const device::MotorParameters &motor = device_of.motor[0];
    const double R_Ohm =
        (1.0 - motor.commutation_ripple) * motor.resistance_Ohm - device().sag_Ohm().maxCoeff();
    const double brake_N =
        tip.force_N(k_T.cwiseProduct(k_T).cwiseProduct(truth().theta_rate_rad_per_s)).norm() /
        R_Ohm;
    double bound_N = last.limits.tip_force_N * (1.0 + kForceRoundOff);
    if (has_tripped()) {
        const double left_N = force_N_ * std::exp(-R_Ohm / (motor.inductance_H * what.servo_hz));
        bound_N = std::max(bound_N, 1.03 * (left_N + std::max(brake_N, brake_N_)));
    }
    above_force_ = force_N > bound_N ? above_force_ + 1 : 0;
    if (force_is_bounded && above_force_ > 1) {
        force_is_bounded = false; // report it once
        ADD_FAILURE() << force_N << " N in tick " << ticks_ << ", after " << force_N_ << " N";
    }
    force_N_ = force_N;
    brake_N_ = brake_N;
    max_force_N_ = std::max(max_force_N_, force_N);
}

void FaultTrial::check_braking() const {
    EXPECT_TRUE(last.command.e_W_V.isZero(0.0));
    EXPECT_TRUE(last.command.cancelled_resistance_Ohm.isZero(0.0));
}

/// The cause can be detected, no cause with precedence is skipped, and its numbers match.
void FaultTrial::check_trip() const {
    const servo::SafetyStatus &status = last.safety;
    const Finding &found = judge.of(status.cause);
    const bool is_contradicted = status.cause == servo::TripCause::motor_contradicted;
    EXPECT_TRUE(found.may || (is_contradicted && may_contradict_))
        << servo::description(status) << ", but the judge has " << found.measured << " of "
        << found.limit;
    for (std::size_t cause = 1; cause < kTripCauses; ++cause) {
        const auto other = static_cast<servo::TripCause>(cause);
        EXPECT_FALSE(precedes(other, status.cause) && judge.of(other).must)
            << servo::kTripCauseNames[cause] << " comes before " << servo::description(status);
    }
    if (says_no_numbers(status.cause)) {
        EXPECT_EQ(status.measured, 0.0);
        return;
    }
    EXPECT_GT(status.measured, status.limit);
    if (is_contradicted) {
        return; // motor_consistency_test.cpp judges its bounds
    }
    EXPECT_NEAR(status.measured, found.measured, 2e-3 * found.limit);
    if (status.cause != servo::TripCause::encoder_jump) { // the monitor defines the size of a jump
        EXPECT_NEAR(status.limit, found.limit, 1e-9 * found.limit);
    }
}

void FaultTrial::run_to_fault() {
    while (ticks_ < what.at_tick && !has_tripped()) {
        step();
    }
    EXPECT_FALSE(has_tripped()) << "before any fault: " << servo::description(last.safety);
}

void FaultTrial::run_to_trip(double at_most_s) {
    for (int i = 0; i < ticks_in(at_most_s) && !has_tripped(); ++i) {
        step();
    }
}

void FaultTrial::expect_tripped_by(servo::TripCause cause) const {
    EXPECT_TRUE(has_tripped());
    EXPECT_EQ(servo::kTripCauseNames[static_cast<std::size_t>(last.safety.cause)],
              servo::kTripCauseNames[static_cast<std::size_t>(cause)])
        << servo::description(last.safety);
    EXPECT_LE(max_ticks_late_, 1);
}

void FaultTrial::expect_latched() {
    const servo::TripCause cause = last.safety.cause;
    for (int i = 0; i < kLatched_ticks; ++i) {
        step();
        ASSERT_TRUE(has_tripped());
        ASSERT_EQ(last.safety.cause, cause);
    }
}

void FaultTrial::reset() {
    ++inputs.reset_count;
    judge.reset();
    since_reset_ = 0;
    recent_.clear();
}

void FaultTrial::expect_reset_trips_again(servo::TripCause cause, double within_s) {
    reset();
    step();
    run_to_trip(within_s);
    expect_tripped_by(cause == servo::TripCause::none ? last.safety.cause : cause);
}

void FaultTrial::expect_recovery() {
    phantom().set_hand_target(what.start_m);
    reset();
    const bool is_void = !device().is_zeroed();
    for (int i = 0; i < ticks_in(is_void ? 0.5 : 4.0); ++i) {
        step();
        ASSERT_FALSE(has_tripped()) << servo::description(last.safety);
        if (last.safety.state != servo::SafetyState::waiting) {
            EXPECT_FALSE(is_void);
            check_rest();
            return;
        }
        check_braking();
    }
    EXPECT_TRUE(is_void) << "does not start again";
}

void FaultTrial::expect_reset_waits() {
    reset();
    for (int i = 0; i < kLatched_ticks; ++i) {
        step();
        ASSERT_NE(last.safety.state, servo::SafetyState::starting);
        check_braking();
    }
}

/// It starts: for 0.1 s the tip was at one place and touched nothing.
void FaultTrial::check_rest() const {
    EXPECT_GE(since_reset_, static_cast<std::uint64_t>(ticks_in(0.1)));
    for (const auto &[tip_m, touching] : recent_) {
        EXPECT_LE((tip_m - last.tip_m).norm(), 2e-3);
        EXPECT_FALSE(touching);
    }
}

} // namespace springdrive::testing
