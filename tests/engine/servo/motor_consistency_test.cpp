// Covers engine/servo/motor_consistency.cpp: wrong encoders under whole servos, judged by the true
// force and speed of the plant, and healthy motors of any kind, which contradict nothing.
#include "engine/servo/motor_consistency.h"

#include "engine/lab/rig/servo_rig.h"
#include "tests/support/cases.h"
#include "tests/support/devices.h"
#include "tests/support/fault_judge.h"
#include "tests/support/fault_trial.h"
#include "tests/support/surfaces.h"
#include "tests/support/tunings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::servo {
namespace {

constexpr double kT_s = 1e-3;

/// The interval of a motor that turns at a constant rate with a steady current.
control::DrivenInterval steady(double e_W_V, double R_hat_Ohm, double current_A,
                               double turned_rad) {
    return {kT_s, e_W_V, 0.0, 0.0, R_hat_Ohm, current_A, current_A, 0.0, turned_rad};
}

/// Ticks until the rotation is contradicted, at most 1000.
int ticks_to_trip(MotorConsistency &motor, const control::DrivenInterval &interval) {
    int ticks = 0;
    while (ticks < 1000 && motor.unexplained_rad() <= motor.limit_rad()) {
        motor.update(interval, 15.0, 35.0);
        ++ticks;
    }
    return ticks;
}

// Without current nothing drops but V_b, at most 0.5 V, and R times the offset.
TEST(MotorConsistency, TripsWhereTheBackEmfMustBe) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const double k_T = device.motor[0].torque_constant_Nm_per_A;
    for (const double e_W_V : {1.0, 2.0, -4.0}) {
        MotorConsistency motor(device, 0, kT_s);
        const int ticks = ticks_to_trip(motor, steady(e_W_V, 1.5, 0.0, 0.0));
        const double beyond_V = 0.98 * std::abs(e_W_V) - 0.5 - 0.02 * 2.5;
        EXPECT_NEAR(ticks, motor.limit_rad() * k_T / (beyond_V * kT_s), 0.15 * ticks + 1);
        // The rotation of that back-EMF, and half of it, which V_b of 0.5 V explains up to 1 V.
        MotorConsistency turning(device, 0, kT_s);
        EXPECT_EQ(ticks_to_trip(turning, steady(e_W_V, 1.5, 0.0, e_W_V * kT_s / k_T)), 1000);
        MotorConsistency reversed(device, 0, kT_s);
        EXPECT_LT(ticks_to_trip(reversed, steady(e_W_V, 1.5, 0.0, -e_W_V * kT_s / k_T)), ticks);
    }
}

// A steady press, then a slow yield of the motor that its encoder does not show.
TEST(MotorConsistency, KnowsALevelBetterThanItsParts) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const double k_T = device.motor[0].torque_constant_Nm_per_A;
    for (const double brush_V : {0.0, 0.5}) {
        MotorConsistency motor(device, 0, kT_s);
        constexpr double kR_Ohm = 2.25;
        constexpr double kR_hat_Ohm = 1.7;
        const double e_W_V = (kR_Ohm - kR_hat_Ohm) * 1.5 + brush_V;
        EXPECT_EQ(ticks_to_trip(motor, steady(e_W_V, kR_hat_Ohm, 1.5, 0.0)), 1000);
        const double rate_rad_per_s = 10.0; // 0.12 m/s at the tip
        const double current_A = 1.5 - k_T * rate_rad_per_s / (kR_Ohm - kR_hat_Ohm);
        EXPECT_EQ(ticks_to_trip(motor, steady(e_W_V, kR_hat_Ohm, current_A, 0.0)) < 1000,
                  brush_V == 0.0 || current_A > 1.0);
    }
}

/// What became of a wrong encoder.
struct Outcome {
    double force_N = 0.0; ///< before it
    double over_s = 0.0;  ///< longest time above the device's limit of force
    double max_m_per_s = 0.0;
    double trip_s = -1.0; ///< after the fault
    TripCause cause = TripCause::none;
    bool has_tripped_before = false; ///< by the press alone; nothing else is then known
};

enum class HandGoes : std::uint8_t { lifted, let_go, moved_free };

struct WrongEncoder {
    HandGoes way = HandGoes::lifted;
    device::FaultKind kind = device::FaultKind::count_scale;
    double size = 0.0;
    Eigen::Index motor = 1;
    std::string tuning = "firm";
    control::MotionMap map = control::MotionMap::transpose;
    bool observes = true;
    double press_N = 9.0; ///< requested of the hand's spring; the servo limits it
    double hand_m_per_s = 0.4;
    double dR_Ohm = 0.0; ///< 0: the tuning's
};

Outcome outcome_of(const WrongEncoder &what) {
    constexpr double kPress_s = 1.2;
    constexpr double kFault_s = 1.7;
    constexpr double kMove_s = 1.9;
    static const contact::HapticSurface box(
        testing::box_soup(Vector3(-0.15, -0.05, -0.15), Vector3(0.15, 0.0, 0.15)));
    simulated::SimulationOptions options;
    options.device_seed = 3;
    options.hand = testing::kFirmHand;
    options.hand.max_speed_m_per_s = what.hand_m_per_s;
    const Vector3 start_m(0.01, 0.012, 0.0);
    const device::DeviceDescription device = testing::phantom_1_0();
    rig::ServoRig rig(device, options, start_m, &box);
    rig.inputs.observes_resistance = what.observes;
    rig.inputs.tuning = testing::tuning(what.tuning);
    rig.inputs.tuning.map = what.map;
    if (what.dR_Ohm > 0.0) { // with the same static stiffness
        rig.inputs.tuning.K_P_V_per_rad *= what.dR_Ohm / rig.inputs.tuning.dR_Ohm;
        rig.inputs.tuning.dR_Ohm = what.dR_Ohm;
    }
    device::Fault fault{.kind = what.kind, .begin_s = std::floor(kFault_s / kT_s)};
    if (what.kind == device::FaultKind::count_scale) {
        fault.size = Vector3::Ones();
    }
    fault.size[what.motor] = what.size;
    rig.device().commit(fault);
    const Vector3 k_T = control::torque_constants(device);
    Outcome found;
    double over_s = 0.0;
    for (int tick = 0; tick < 3200; ++tick) {
        const double time_s = kT_s * tick;
        if (time_s > kPress_s && what.way != HandGoes::moved_free) {
            rig.phantom().set_hand_target(
                {0.014, -what.press_N / options.hand.stiffness_N_per_m - 0.004, 0.0});
        }
        if (time_s > kMove_s && what.way == HandGoes::lifted) {
            rig.phantom().set_hand_target({0.0, 0.08, 0.01});
        } else if (tick == std::lround(kMove_s / kT_s) && what.way == HandGoes::let_go) {
            rig.phantom().hold_with({0.0, 0.0, 0.0, 0.0, 1.0});
        } else if (time_s > kMove_s && what.way == HandGoes::moved_free) {
            const double s = time_s - kMove_s;
            rig.phantom().set_hand_target(start_m + Vector3(0.04 * std::sin(6.0 * s),
                                                            0.03 * (1.0 - std::cos(5.0 * s)),
                                                            0.02 * std::sin(7.0 * s)));
        }
        rig.tick();
        const testing::TipAt tip(device.geometry, rig.truth().theta_rad);
        const double force_N = tip.force_N(k_T.cwiseProduct(rig.truth().current_A)).norm();
        if (time_s < kFault_s) {
            found.force_N = force_N;
            found.has_tripped_before = rig.has_tripped();
            if (found.has_tripped_before) {
                return found;
            }
            continue;
        }
        over_s = force_N > device.limits.tip_force_N ? over_s + kT_s : 0.0;
        found.over_s = std::max(found.over_s, over_s);
        found.max_m_per_s = std::max(found.max_m_per_s, rig.truth().tip_velocity_m_per_s.norm());
        if (rig.has_tripped() && found.trip_s < 0.0) {
            found.trip_s = time_s - kMove_s;
            found.cause = rig.last.safety.cause;
        }
        EXPECT_TRUE(found.trip_s < 0.0 || rig.has_tripped()) << "starts by itself";
    }
    return found;
}

// Without this check encoder 2 made 8.8 N in free air at dR 0.2 Ω, and no trip at 0.5 Ω.
TEST(MotorConsistency, ADeadEncoderTripsOnceItsMotorMoves) {
    for (const auto &[tuning, dR_Ohm] :
         {std::pair("firm", 0.0), {"stable_only_1kHz", 0.0}, {"firm", 2.0}}) {
        for (const bool observes : {true, false}) {
            for (const HandGoes way : {HandGoes::lifted, HandGoes::let_go, HandGoes::moved_free}) {
                WrongEncoder what;
                what.way = way;
                what.tuning = tuning;
                what.dR_Ohm = dR_Ohm;
                what.observes = observes;
                what.map = observes ? control::MotionMap::transpose : control::MotionMap::inverse;
                const Outcome found = outcome_of(what);
                SCOPED_TRACE(std::string(tuning) + ", way " +
                             std::to_string(static_cast<int>(way)) + ", observed " +
                             std::to_string(observes));
                EXPECT_FALSE(found.has_tripped_before);
                EXPECT_GT(found.force_N, way == HandGoes::moved_free ? 0.0 : 4.0);
                EXPECT_LE(found.over_s, 0.02);
                EXPECT_LE(found.max_m_per_s, 2.2);
                if (way != HandGoes::moved_free) { // where a dead motor only damps
                    EXPECT_EQ(kTripCauseNames[static_cast<std::size_t>(found.cause)],
                              "motor_contradicted");
                    EXPECT_LT(found.trip_s, 0.1);
                }
                std::printf("%s dR %g way %d observed %d: %.1f N, over for %.0f ms, %.2f m/s, "
                            "tripped after %.0f ms\n",
                            tuning, dR_Ohm, static_cast<int>(way), observes, found.force_N,
                            1e3 * found.over_s, found.max_m_per_s, 1e3 * found.trip_s);
            }
        }
    }
}

// A motor that hardly moves shows nothing, and does no harm; others trip by this or by force, speed
// or energy.
TEST(MotorConsistency, NoWrongEncoderMakesMoreThanTheLimits) {
    constexpr std::array<std::pair<device::FaultKind, double>, 6> kFaults{
        {{device::FaultKind::count_scale, 0.0},
         {device::FaultKind::count_scale, 0.5},
         {device::FaultKind::count_scale, 2.0},
         {device::FaultKind::count_scale, -1.0},
         {device::FaultKind::count_stuck_bit, 32.0},
         {device::FaultKind::count_flicker, 4.0}}};
    std::mt19937 random(1);
    const int cases = testing::cases(18, 1000);
    int contradicted = 0;
    int before = 0;
    double worst_s = 0.0;
    double fastest_m_per_s = 0.0;
    std::string worst = "none above the limit";
    for (int i = 0; i < cases; ++i) {
        const auto &[kind, size] = kFaults[static_cast<std::size_t>(i) % kFaults.size()];
        WrongEncoder what;
        what.kind = kind;
        what.size = size;
        what.motor = i / 6 % 3;
        what.way = static_cast<HandGoes>(random() % 3);
        what.tuning = i % 2 == 0 ? "firm" : "stable_only_1kHz";
        what.map = random() % 2 == 0 ? control::MotionMap::inverse : control::MotionMap::transpose;
        what.observes = random() % 2 == 0;
        what.press_N = testing::uniform(random, 2.0, 12.0);
        what.hand_m_per_s = testing::log_uniform(random, 0.05, 0.6);
        const Outcome found = outcome_of(what);
        if (found.has_tripped_before) { // 12 N overshoot the limit of 8.5
            ++before;
            continue;
        }
        const std::string name =
            "case " + std::to_string(i) + ", fault " + std::to_string(static_cast<int>(kind)) +
            " of " + std::to_string(size) + ", motor " + std::to_string(what.motor + 1) + ", way " +
            std::to_string(static_cast<int>(what.way));
        EXPECT_LE(found.over_s, 0.02) << name;
        EXPECT_LE(found.max_m_per_s, 2.2) << name;
        contradicted += found.cause == TripCause::motor_contradicted ? 1 : 0;
        fastest_m_per_s = std::max(fastest_m_per_s, found.max_m_per_s);
        if (found.over_s > worst_s) {
            worst_s = found.over_s;
            worst = name;
        }
    }
    EXPECT_GT(contradicted, 0);
    EXPECT_LT(before, cases / 5);
    std::printf("worst of %d: %.0f ms above the limit (%s), %.2f m/s; %d contradicted\n",
                cases - before, 1e3 * worst_s, worst.c_str(), fastest_m_per_s, contradicted);
}

/// A healthy device, drawn, with brushes, in any air, in hands that tap, press, slide and swing.
/// @return the largest unexplained rotation as a share of its limit
double largest_share(int number) {
    std::mt19937 random(static_cast<std::uint32_t>(number));
    const auto any = [&](std::uint32_t below) {
        return static_cast<std::uint32_t>(random()) % below;
    };
    simulated::SimulationOptions options;
    options.device_seed = any(6) == 0 ? 0 : static_cast<std::uint64_t>(number) + 1;
    options.servo_period_s = std::array{1e-3, 0.25e-3, 2e-3}[any(3)];
    options.delay_periods = std::array{0.0, 0.4, 1.0}[any(3)];
    options.ambient_C = testing::uniform(random, 15.0, 35.0);
    options.brush_voltage_V = std::array{0.0, 0.05, 0.2, 0.5}[any(4)];
    options.brush_current_A = std::array{0.01, 0.03, 0.06}[any(3)];
    options.effects.structural_compliance = any(4) == 0;
    options.hand = any(2) == 0 ? device::HandParameters{} : testing::kFirmHand;
    options.hand.max_speed_m_per_s = testing::uniform(random, 0.05, 1.5);
    device::DeviceDescription device = testing::phantom_1_0();
    device.current_sensing.is_shared = any(5) != 0;
    static const contact::HapticSurface box(
        testing::box_soup(Vector3(-0.15, -0.05, -0.15), Vector3(0.15, 0.0, 0.15)));
    const Vector3 start_m(testing::uniform(random, -0.03, 0.03), 0.02,
                          testing::uniform(random, -0.02, 0.02));
    rig::ServoRig rig(device, options, start_m, any(6) == 0 ? nullptr : &box);
    rig.inputs.observes_resistance = any(3) != 0;
    const bool is_quick = options.servo_period_s < 1.5e-3 && options.delay_periods < 0.5;
    rig.inputs.tuning =
        testing::tuning(is_quick ? std::array{"firm", "stable_only_1kHz"}[any(2)] : "soft");
    std::vector<MotorConsistency> motor;
    for (std::size_t j = 0; j < 3; ++j) {
        motor.emplace_back(rig.phantom().description(), j, options.servo_period_s);
    }
    const double depth_m = options.hand.stiffness_N_per_m > 1000.0 ? 0.006 : 0.02;
    const std::uint32_t style = any(3);
    const int ticks = static_cast<int>(std::lround(2.6 / options.servo_period_s));
    double next_s = 1.1;
    double largest = 0.0;
    for (int tick = 0; tick < ticks && !rig.has_tripped(); ++tick) {
        const double time_s = options.servo_period_s * tick;
        if (style < 2 && time_s > next_s) {
            rig.phantom().set_hand_target({start_m.x() + testing::uniform(random, -0.02, 0.02),
                                           style == 0 ? testing::uniform(random, -depth_m, 0.03)
                                                      : (any(2) == 0 ? 0.01 : -depth_m),
                                           start_m.z()});
            next_s = time_s + testing::log_uniform(random, 0.02, 0.6);
        } else if (style == 2 && time_s > next_s) {
            const double s = time_s - next_s;
            rig.phantom().set_hand_target(start_m + Vector3(0.05 * std::sin(9.0 * s),
                                                            0.04 * std::sin(7.3 * s) + 0.02,
                                                            0.03 * std::sin(11.0 * s)));
        }
        if (any(200) == 0) {
            rig.device().pass_by(1);
        }
        rig.tick();
        for (std::size_t j = 0; j < 3; ++j) {
            if (!lets_pass(rig.last.safety.state)) {
                motor[j].reset();
            } else if (const auto &interval = rig.loop().observers().interval(j)) {
                motor[j].update(*interval, rig.last.winding[j].min_C, rig.last.winding[j].max_C);
                largest = std::max(largest, motor[j].unexplained_rad() / motor[j].limit_rad());
            }
        }
    }
    EXPECT_NE(rig.last.safety.cause, TripCause::motor_contradicted) << number;
    return largest;
}

TEST(MotorConsistency, HealthyMotorsContradictNothing) {
    const int cases = testing::cases(10, 3000);
    double largest = 0.0;
    for (int i = 0; i < cases; ++i) {
        largest = std::max(largest, largest_share(i));
    }
    EXPECT_LT(largest, 1.0 / 1.5); // room for what is not simulated
    std::printf("worst of %d: %.3f of the limit\n", cases, largest);
}

} // namespace
} // namespace springdrive::servo
