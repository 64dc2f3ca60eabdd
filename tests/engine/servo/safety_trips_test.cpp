// Covers engine/servo/safety_monitor.cpp: both sides of every cause of a trip.
#include "device/simulated/simulated_phantom.h"
#include "tests/engine/servo/safety_monitor_fixture.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::servo {
namespace {

/// The monitor's inputs of a tick.
struct Tick {
    Observation seen;
    SafetyOrders orders;
    device::DeviceCommand requested;
};

class SafetyTrips : public testing::SafetyMonitorTest {
protected:
    [[nodiscard]] Tick fine() const { return {calm(), {}, little()}; }

    device::DeviceCommand pass_tick(const Tick &tick) {
        return pass(tick.seen, tick.orders, tick.requested);
    }

    void pass_ticks(const Tick &tick, int count) {
        for (int i = 0; i < count; ++i) {
            pass_tick(tick);
        }
    }
    /// The same; the monitor is in this state after each of them.
    void pass_ticks_in(SafetyState state, const Tick &tick, int count) {
        for (int i = 0; i < count; ++i) {
            pass_tick(tick);
            ASSERT_EQ(monitor.status().state, state) << i << ": " << description(monitor.status());
        }
    }

    [[nodiscard]] Tick with_speed(double speed_m_per_s) const {
        Tick tick = fine();
        tick.seen.now.theta_rate_rad_per_s =
            tick.seen.now.J.inverse() * Vector3(0.0, speed_m_per_s, 0.0);
        return tick;
    }

    /// Expects a trip in this tick that persists for any further inputs.
    void expect_tripped(const device::DeviceCommand &command, TripCause cause) {
        expect_braking(command);
        EXPECT_EQ(monitor.status().state, SafetyState::tripped);
        EXPECT_EQ(monitor.status().cause, cause) << description(monitor.status());
        for (int i = 0; i < 200; ++i) {
            expect_braking(pass(calm()));
        }
        EXPECT_EQ(monitor.status().state, SafetyState::tripped);
        EXPECT_EQ(monitor.status().cause, cause);
    }

    /// Just within the limit nothing happens; just beyond, it trips immediately, latches, trips
    /// again after a reset while the cause persists, and starts after a reset once it is gone.
    void expect_line(const Tick &within, const Tick &beyond, TripCause cause) {
        start_up();
        pass_ticks_in(SafetyState::running, within, 100);
        expect_tripped(pass_tick(beyond), cause);
        monitor.reset();
        expect_tripped(pass_tick(beyond), cause);
        monitor.reset();
        start_up();
    }

    void expect_numbers(const Tick &beyond, double measured, double limit) {
        pass_tick(beyond);
        EXPECT_NEAR(monitor.status().measured, measured, 1e-9 * std::abs(measured));
        EXPECT_NEAR(monitor.status().limit, limit, 1e-12 * limit);
        monitor.reset();
    }

    /// All but `none`, `assertion` and `torn_inputs`, which is of old records.
    [[nodiscard]] static std::vector<std::pair<TripCause, std::function<void(Tick &)>>>
    every_cause() {
        return {
            {TripCause::emergency_stop, [](Tick &t) { t.orders.requested_stop = 1; }},
            {TripCause::device_lost,
             [](Tick &t) { t.seen.link.health = device::DeviceHealth::lost; }},
            {TripCause::board_fault,
             [](Tick &t) { t.seen.link.faults.bits = device::BoardFaults::kTemperature; }},
            {TripCause::stale_measurement,
             [](Tick &t) {
                 t.seen.link.arrival = device::Arrival::late;
                 t.orders.limits.stale_s = 0.5e-3;
             }},
            {TripCause::not_finite, [](Tick &t) { t.seen.all_finite = false; }},
            {TripCause::missed_deadlines, [](Tick &t) { t.seen.link.missed_in_a_row = 51; }},
            {TripCause::window_silent, [](Tick &t) { t.orders.limits.window_silence_s = 1e-3; }},
            {TripCause::encoder_jump, [](Tick &t) { t.seen.now.tip_m.x() += 0.1; }},
            {TripCause::motor_contradicted, // it turns, and there is no current
             [](Tick &t) { t.seen.interval[0] = {.duration_s = 0.1, .after_rad = 10.0}; }},
            {TripCause::current, [](Tick &t) { t.seen.current_A[0] = 9.0; }},
            {TripCause::tip_force, [](Tick &t) { t.seen.tip_force_N[0] = 9.0; }},
            {TripCause::tip_speed,
             [](Tick &t) {
                 t.seen.now.theta_rate_rad_per_s = t.seen.now.J.inverse() * Vector3(9.0, 0.0, 0.0);
             }},
            {TripCause::winding_temperature, [](Tick &t) { t.orders.limits.winding_C = 30.0; }},
            {TripCause::beyond_stops, [](Tick &t) { t.seen.now.theta_rad[0] = 100.0; }},
            {TripCause::energy,
             [](Tick &t) {
                 t.orders.limits.generated_energy_J = 1e-6;
                 t.seen.tip_force_N[0] = std::max(5.0, t.seen.tip_force_N[0]);
                 t.seen.now.tip_m.x() += 1e-3; // 2.5 mJ with the mean of 0 and 5 N
             }},
            {TripCause::voltage, [](Tick &t) { t.requested.e_W_V[0] = 0.4; }}};
    }
};

TEST_F(SafetyTrips, TipSpeed) {
    const double limit = device.limits.tip_speed_m_per_s;
    expect_line(with_speed(0.999 * limit), with_speed(1.001 * limit), TripCause::tip_speed);
    expect_numbers(with_speed(-1.001 * limit), 1.001 * limit, limit);
}

TEST_F(SafetyTrips, TipForceAtOnce) {
    Tick within = fine();
    Tick beyond = fine();
    const double limit = device.limits.tip_force_N;
    within.seen.tip_force_N = Vector3(0.0, -0.999 * limit, 0.0);
    beyond.seen.tip_force_N = Vector3(0.0, -1.001 * limit, 0.0);
    expect_line(within, beyond, TripCause::tip_force);
    expect_numbers(beyond, 1.001 * limit, limit);
}

TEST_F(SafetyTrips, CurrentOfEachMotorByItsOwnLimit) {
    for (std::size_t j = 0; j < 3; ++j) {
        device.motor[j].peak_current_A = 3.0 + static_cast<double>(j);
    }
    for (Eigen::Index j = 0; j < 3; ++j) {
        monitor = SafetyMonitor(device, kPeriod_s);
        Tick within = fine();
        Tick beyond = fine();
        const double limit = 3.0 + static_cast<double>(j);
        within.seen.current_A[j] = -0.999 * limit;
        beyond.seen.current_A[j] = -1.001 * limit;
        expect_line(within, beyond, TripCause::current);
        expect_numbers(beyond, 1.001 * limit, limit);
    }
}

TEST_F(SafetyTrips, EmergencyStop) {
    Tick stop = fine();
    stop.orders.requested_stop = 1;
    start_up();
    expect_tripped(pass_tick(stop), TripCause::emergency_stop);
    EXPECT_FALSE(monitor.reset());
    expect_tripped(pass_tick(stop), TripCause::emergency_stop);
    stop.orders.released_stop = 1;
    EXPECT_TRUE(monitor.reset(stop.orders.released_stop));
    pass_tick(stop);
    EXPECT_EQ(monitor.status().state, SafetyState::waiting);
}

TEST_F(SafetyTrips, ALostDevice) {
    Tick lost = fine();
    lost.seen.link.health = device::DeviceHealth::lost;
    expect_line(fine(), lost, TripCause::device_lost);
}

TEST_F(SafetyTrips, WhateverIsNotFinite) {
    std::vector<std::function<double &(Tick &)>> numbers;
    for (const Eigen::Index j : {0, 1, 2}) {
        numbers.insert(
            numbers.end(),
            {[j](Tick &t) -> double & { return t.seen.tip_force_N[j]; },
             [j](Tick &t) -> double & { return t.seen.current_A[j]; },
             [j](Tick &t) -> double & { return t.seen.now.tip_m[j]; },
             [j](Tick &t) -> double & { return t.seen.now.theta_rate_rad_per_s[j]; },
             [j](Tick &t) -> double & { return t.seen.spring_force_N[j]; },
             [j](Tick &t) -> double & { return t.seen.spring_stretch_m[j]; },
             [j](Tick &t) -> double & { return t.requested.e_W_V[j]; },
             [j](Tick &t) -> double & { return t.requested.cancelled_resistance_Ohm[j]; }});
    }
    start_up();
    for (const auto &number : numbers) {
        for (const double bad :
             {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
              -std::numeric_limits<double>::infinity()}) {
            Tick tick = fine();
            number(tick) = bad;
            expect_braking(pass_tick(tick));
            EXPECT_EQ(monitor.status().cause, TripCause::not_finite);
            monitor.reset();
        }
    }
    Tick elsewhere = fine();
    elsewhere.seen.all_finite = false;
    monitor = SafetyMonitor(device, kPeriod_s);
    expect_line(fine(), elsewhere, TripCause::not_finite);
}

TEST_F(SafetyTrips, MissedDeadlines) {
    Tick within = fine();
    Tick beyond = fine();
    within.seen.link.missed_in_a_row = 50;
    beyond.seen.link.missed_in_a_row = 51;
    expect_line(within, beyond, TripCause::missed_deadlines);
    expect_numbers(beyond, 0.051, 0.05);
}

TEST_F(SafetyTrips, AWindowWithoutHeartbeat) {
    Tick tick = fine();
    for (std::uint32_t i = 1; i <= 5000; ++i) { // a heartbeat every 0.1 s
        tick.orders.heartbeat = 1 + i / 100;
        pass_tick(tick);
    }
    EXPECT_EQ(monitor.status().state, SafetyState::running);
    tick.orders.heartbeat = 1000;
    pass_tick(tick);
    pass_ticks_in(SafetyState::running, tick, 1999);
    pass_tick(tick);
    pass_tick(tick); // a sum of 2000 periods may be on either side of 2 s
    EXPECT_EQ(monitor.status().cause, TripCause::window_silent);
    EXPECT_EQ(monitor.status().limit, device.limits.window_silence_s);
    EXPECT_NEAR(monitor.status().measured, device.limits.window_silence_s, 1.5 * kPeriod_s);
    expect_tripped(pass_tick(tick), TripCause::window_silent);
    // A reset restarts the time since the last heartbeat.
    monitor.reset();
    pass_ticks(tick, 1998);
    EXPECT_NE(monitor.status().state, SafetyState::tripped);
    pass_ticks(tick, 4);
    EXPECT_EQ(monitor.status().cause, TripCause::window_silent);
}

TEST_F(SafetyTrips, MissedTicksCountAsSilenceToo) {
    start_up();
    Tick tick = fine();
    tick.orders.heartbeat = 1;
    pass_tick(tick);
    tick.seen.missed_periods = 9; // ten periods each
    pass_ticks_in(SafetyState::running, tick, 199);
    pass_tick(tick);
    pass_tick(tick);
    EXPECT_EQ(monitor.status().cause, TripCause::window_silent);
}

TEST_F(SafetyTrips, AHeartbeatOfZeroDisablesTheCheck) {
    start_up();
    pass_calm(10'000);
    EXPECT_EQ(monitor.status().state, SafetyState::running);
}

TEST_F(SafetyTrips, EncoderJumps) {
    // 1.5 times the displacement at the maximum speed, plus three counts of each motor.
    const double counts_m = 3.0 * 2.0 * std::numbers::pi / 4096 * calm().now.J.norm();
    for (const std::uint32_t missed : {0U, 4U}) {
        const double limit_m =
            1.5 * device.limits.tip_speed_m_per_s * (1.0 + missed) * kPeriod_s + counts_m;
        for (const double share : {0.999, 1.001}) {
            monitor = SafetyMonitor(device, kPeriod_s);
            start_up();
            Tick tick = fine();
            tick.orders.limits.tip_speed_m_per_s = 0.01; // a lowered speed limit does not turn a
                                                         // step into a jump
            tick.seen.now.tip_m.x() += share * limit_m;
            tick.seen.missed_periods = missed;
            pass_tick(tick);
            EXPECT_EQ(monitor.status().state == SafetyState::tripped, share > 1.0);
            if (share > 1.0) {
                EXPECT_EQ(monitor.status().cause, TripCause::encoder_jump);
                EXPECT_NEAR(monitor.status().measured, share * limit_m, 1e-12);
                EXPECT_NEAR(monitor.status().limit, limit_m, 1e-12);
                monitor.reset(); // at the new position it is no longer a jump
                pass_tick(tick);
                EXPECT_EQ(monitor.status().state, SafetyState::waiting);
            }
        }
    }
}

TEST_F(SafetyTrips, AnglesBeyondTheStops) {
    const device::JointLimits &limits = device.joint_limits;
    const double give_rad = device.limits.beyond_stops_rad;
    const auto at_q = [&](const Vector3 &q_rad) {
        Tick tick = fine();
        tick.seen.now.theta_rad =
            device::motor_from_joint(device.geometry, q_rad); // the tip elsewhere
        return tick;
    };
    for (const double sign : {-1.0, 1.0}) {
        Vector3 q_rad(sign > 0.0 ? limits.max_rad[0] : limits.min_rad[0], 0.2, 0.1);
        const Vector3 out_rad(sign * give_rad, 0.0, 0.0);
        monitor = SafetyMonitor(device, kPeriod_s);
        expect_line(at_q(q_rad + 0.999 * out_rad), at_q(q_rad + 1.001 * out_rad),
                    TripCause::beyond_stops);
        expect_numbers(at_q(q_rad + 1.001 * out_rad), 1.001 * give_rad, give_rad);
        const double fold_rad =
            sign > 0.0 ? limits.max_q3_minus_q2_rad : limits.min_q3_minus_q2_rad;
        q_rad = Vector3(0.0, 0.9, 0.9 + fold_rad);
        const Vector3 folded_rad(0.0, 0.0, sign * give_rad);
        expect_line(at_q(q_rad + 0.999 * folded_rad), at_q(q_rad + 1.001 * folded_rad),
                    TripCause::beyond_stops);
    }
}

TEST_F(SafetyTrips, GeneratedEnergy) {
    // Work in one direction by a force along the motion: 5 N over 6 mm are the 30 mJ.
    for (const double share : {0.99, 1.01}) {
        monitor = SafetyMonitor(device, kPeriod_s);
        start_up();
        Tick tick = fine();
        tick.seen.tip_force_N = Vector3(5.0, 0.0, 0.0);
        pass_tick(tick);
        pass_tick(tick);          // from here on the mean of start and end is 5 N
        constexpr int kSteps = 6; // short compared with the memory: 0.6 % mean decay
        for (int i = 0; i < kSteps; ++i) {
            ASSERT_EQ(monitor.status().state, SafetyState::running);
            tick.seen.now.tip_m.x() += share * 6.0e-3 * 1.006 / kSteps;
            pass_tick(tick);
        }
        EXPECT_EQ(monitor.status().state == SafetyState::tripped, share > 1.0)
            << monitor.generated_energy_J();
        if (share > 1.0) {
            EXPECT_EQ(monitor.status().cause, TripCause::energy);
            EXPECT_EQ(monitor.status().limit, device.limits.generated_energy_J);
            EXPECT_GT(monitor.status().measured, device.limits.generated_energy_J);
        }
    }
}

TEST_F(SafetyTrips, SustainedVoltage) {
    const double limit = 0.35; // below what force and current limits allow
    device.motor[1].supply_V = limit;
    monitor = SafetyMonitor(device, kPeriod_s);
    Tick within = fine();
    Tick beyond = fine();
    within.requested.e_W_V[1] = -0.999 * limit;
    beyond.requested.e_W_V[1] = -1.001 * limit;
    start_up();
    const int tolerated = static_cast<int>(std::lround(kVoltageTolerated_s / kPeriod_s));
    for (int times = 0; times < 3; ++times) { // short peaks, with a tick in between
        pass_ticks_in(SafetyState::running, beyond, tolerated);
        pass_tick(within);
    }
    pass_ticks_in(SafetyState::running, within, 100);
    pass_ticks(beyond, tolerated);
    const device::DeviceCommand command = pass_tick(beyond);
    EXPECT_NEAR(monitor.status().measured, 1.001 * limit, 1e-9);
    EXPECT_EQ(monitor.status().limit, limit);
    expect_tripped(command, TripCause::voltage);
    monitor.reset(); // while waiting the tip may be deep in a surface: the motors are not driven
    pass_ticks_in(SafetyState::waiting, beyond, 90);
    pass_ticks(beyond, 1200);
    EXPECT_EQ(monitor.status().cause, TripCause::voltage); // trips again once the gains have ramped
                                                           // up
}

TEST_F(SafetyTrips, WindingTemperatureByALoweredLimit) {
    // Unloaded windings are at most at the temperature of the warmest air.
    Tick within = fine();
    Tick beyond = fine();
    within.orders.limits.winding_C = device::kWarmestAir_C + 0.01;
    beyond.orders.limits.winding_C = device::kWarmestAir_C - 0.01;
    expect_line(within, beyond, TripCause::winding_temperature);
    expect_numbers(beyond, device::kWarmestAir_C, device::kWarmestAir_C - 0.01);
}

TEST_F(SafetyTrips, LoweredLimitsApplyAndRaisedOnesDoNot) {
    const SafetyLimits of_device = limits_of(device);
    Tick tick = with_speed(0.8 * of_device.tip_speed_m_per_s);
    tick.seen.tip_force_N = Vector3(0.8 * of_device.tip_force_N, 0.0, 0.0);
    tick.seen.current_A = Vector3(0.8 * of_device.current_A, 0.0, 0.0);
    tick.seen.link.missed_in_a_row = 40;
    const std::vector<std::pair<double SafetyLimits::*, TripCause>> limits{
        {&SafetyLimits::late_s, TripCause::missed_deadlines},
        {&SafetyLimits::current_A, TripCause::current},
        {&SafetyLimits::tip_force_N, TripCause::tip_force},
        {&SafetyLimits::tip_speed_m_per_s, TripCause::tip_speed}};
    for (const auto &[limit, cause] : limits) {
        for (const double share : {0.79, 0.81, 1000.0}) {
            monitor = SafetyMonitor(device, kPeriod_s);
            start_up();
            Tick lowered_to = tick;
            lowered_to.orders.limits.*limit = share * (of_device.*limit);
            for (int i = 0; i < 300 && monitor.status().cause == TripCause::none; ++i) {
                const double before = monitor.limits().*limit;
                pass_tick(lowered_to);
                const bool glides =
                    limit == &SafetyLimits::current_A || limit == &SafetyLimits::tip_force_N;
                if (glides) { // a second from the full limit to zero
                    EXPECT_LE(before - monitor.limits().*limit,
                              (of_device.*limit) * kPeriod_s / kLimitGlide_s * (1.0 + 1e-9));
                }
            }
            EXPECT_EQ(monitor.status().cause, share < 0.8 ? cause : TripCause::none);
            if (share > 0.8) {
                EXPECT_NEAR(monitor.limits().*limit, std::min(share, 1.0) * (of_device.*limit),
                            1e-12 * (of_device.*limit));
            }
        }
        // However much it is raised, the device's own limit applies: slightly beyond it trips.
        monitor = SafetyMonitor(device, kPeriod_s);
        start_up();
        Tick beyond = tick;
        beyond.seen.now.theta_rate_rad_per_s *= 1.3;
        beyond.seen.tip_force_N *= 1.3;
        beyond.seen.current_A *= 1.3;
        beyond.seen.link.missed_in_a_row = 52;
        for (const SafetyLimit &every : kSafetyLimits) {
            beyond.orders.limits.*every.value = 1e9;
        }
        pass_tick(beyond);
        EXPECT_EQ(monitor.status().state, SafetyState::tripped);
    }
}

TEST_F(SafetyTrips, NamesTheFirstCauseAndKeepsIt) {
    start_up();
    pass_tick(with_speed(7.0));
    Tick stop = fine();
    stop.orders.requested_stop = 1;
    pass_tick(stop);
    EXPECT_EQ(monitor.status().cause, TripCause::tip_speed);
    EXPECT_NEAR(monitor.status().measured, 7.0, 1e-9);
    EXPECT_DOUBLE_EQ(monitor.status().limit, device.limits.tip_speed_m_per_s);
}

TEST_F(SafetyTrips, ReportsTheFirstInTheListOfSimultaneousCauses) {
    // All causes from one to the last, in one tick.
    const auto causes = every_cause();
    device.motor[0].supply_V = 0.25;
    ASSERT_EQ(causes.size() + 3, kTripCauseNames.size());
    for (std::size_t first = 0; first < causes.size(); ++first) {
        monitor = SafetyMonitor(device, kPeriod_s);
        start_up();
        Tick tick = fine();
        tick.orders.heartbeat = 7;
        causes.back().second(tick); // 20 ms of too much voltage are tolerated
        pass_ticks(tick, 20);
        ASSERT_EQ(monitor.status().state, SafetyState::running);
        for (std::size_t i = first; i < causes.size(); ++i) {
            causes[i].second(tick);
        }
        expect_tripped(pass_tick(tick), causes[first].first);
    }
}

/// A requested stop, before, with or after each cause of a trip, by the window or by the board's
/// switch: with any number of resets by a program the motors stay off. That they are off is seen at
/// the currents of a simulated device, which gets what the monitor passes.
TEST_F(SafetyTrips, ARequestedStopHoldsWhateverElseTripsUntilItIsReleased) {
    constexpr int kCause = 300; // ticks
    constexpr int kPresent = 100;
    constexpr int kDecayed = 200; // of the currents, and of the motion that they left
    constexpr int kEnd = 900;
    constexpr double kNone_A = 1e-5;
    simulated::SimulationOptions still;
    still.effects = simulated::PlantEffects::none();
    still.hand = {1.0, 100.0, 1e5, 50.0};
    const device::DeviceDescription plant_of = device;
    device.motor[0].supply_V = 0.25;
    const auto causes = every_cause();
    ASSERT_EQ(causes.size() + 3, kTripCauseNames.size());
    for (const auto &[cause, apply] : causes) {
        for (const int pressed : {kCause - 200, kCause, kCause + 20, kCause + 200}) {
            for (const bool by_switch : {false, true}) {
                SCOPED_TRACE(std::string(kTripCauseNames[static_cast<std::size_t>(cause)]) +
                             ", pressed at " + std::to_string(pressed) +
                             (by_switch ? " by switch" : ""));
                monitor = SafetyMonitor(device, kPeriod_s);
                start_up();
                simulated::SimulatedPhantom plant(plant_of, still, Vector3(0.0, 0.02, 0.0));
                std::uint32_t released = 0;
                const auto tick_at = [&, &add_cause = apply](int number) {
                    Tick tick = fine();
                    if (number >= kCause && number < kCause + kPresent) {
                        tick.orders.heartbeat = 7;
                        add_cause(tick);
                    }
                    if (by_switch && number >= pressed && number < pressed + 20) {
                        tick.seen.link.faults.bits |= device::BoardFaults::kStop;
                    } else if (!by_switch && number >= pressed) {
                        tick.orders.requested_stop = 2; // as there may be one among the causes
                    }
                    tick.orders.released_stop = released;
                    static_cast<void>(plant.read());
                    plant.write(pass_tick(tick));
                };
                for (int number = 0; number < kEnd; ++number) {
                    tick_at(number);
                    if (number % 7 == 0) {
                        monitor.reset();
                    }
                    if (number >= pressed) {
                        ASSERT_EQ(monitor.status().state, SafetyState::tripped) << number;
                        ASSERT_NE(monitor.status().held_stop, 0U) << number;
                    }
                    if (number > pressed + kDecayed) {
                        ASSERT_LT(plant.truth().current_A.norm(), kNone_A) << number;
                    }
                }
                EXPECT_NE(description(monitor.status()).find("stop"), std::string::npos);
                released = monitor.status().held_stop;
                EXPECT_TRUE(monitor.reset(released));
                for (int number = kEnd; number < kEnd + 1200; ++number) {
                    tick_at(number);
                }
                ASSERT_EQ(monitor.status().state, SafetyState::running)
                    << description(monitor.status());
                EXPECT_GT(plant.truth().current_A.norm(), 0.01);
            }
        }
    }
}

/// Each press has its number, and a switch that stays on one more after every reset.
TEST_F(SafetyTrips, AReleaseIsOfTheStopsUpToItsNumber) {
    Tick tick = fine();
    start_up();
    tick.orders.requested_stop = 1;
    pass_tick(tick);
    ASSERT_EQ(monitor.status().held_stop, 1U);
    tick.seen.link.faults.bits = device::BoardFaults::kStop; // while it is stopped
    pass_tick(tick);
    EXPECT_EQ(monitor.status().held_stop, 2U);
    tick.orders.released_stop = 1; // on its way before the switch was seen
    EXPECT_FALSE(monitor.reset(1));
    pass_tick(tick);
    EXPECT_EQ(monitor.status().state, SafetyState::tripped);
    tick.orders.released_stop = 2;
    EXPECT_TRUE(monitor.reset(2)); // while it is still on
    for (int i = 0; i < 120; ++i) {
        expect_braking(pass_tick(tick));
    }
    EXPECT_EQ(monitor.status().held_stop, 3U);
    tick.seen.link.faults.bits = 0;
    for (int i = 0; i < 1200; ++i) {
        monitor.reset(2); // whoever resets: nobody has released this one
        expect_braking(pass_tick(tick));
    }
    tick.orders.released_stop = 3;
    EXPECT_TRUE(monitor.reset(3));
    pass_ticks(tick, 1200);
    EXPECT_EQ(monitor.status().state, SafetyState::running);
}

} // namespace
} // namespace springdrive::servo
