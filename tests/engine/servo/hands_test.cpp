// Covers what whole servos do to hands that do nothing wrong: those that press, tap and slide as
// people do never trip the safety monitor, with any tuning, rate and surface; the soft wall acts
// before every joint's stop, with any tuning, and also at η = 1.
#include "base/degrees.h"
#include "device/core/phantom/kinematics.h"
#include "tests/support/devices.h"
#include "tests/support/fault_trial.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::servo {
namespace {

struct Hand {
    const char *name = "";
    device::HandParameters parameters{};
    double depth_m = 0.0; ///< of its target, when it presses
};

const std::array<Hand, 3> kHands{{{"light", testing::kLightHand, 0.025},
                                  {"relaxed", device::HandParameters{}, 0.012},
                                  {"firm", testing::kFirmHand, 0.004}}};

/// Rests, taps thrice, presses, slides 20 mm and lifts.
simulated::SimulationOptions taps_and_presses(const testing::FaultCase &what, double speed_m_per_s,
                                              double depth_m) {
    std::vector<simulated::HandPath::Point> points{{0.0, what.start_m}, {1.15, what.start_m}};
    const auto go = [&](const Vector3 &to_m) {
        const simulated::HandPath::Point from = points.back();
        points.push_back({from.time_s + (to_m - from.position_m).norm() / speed_m_per_s, to_m});
    };
    const Vector3 above = Vector3(what.start_m.x(), 0.005, what.start_m.z());
    const Vector3 below = Vector3(what.start_m.x(), -depth_m, what.start_m.z());
    go(above);
    for (int tap = 0; tap < 3; ++tap) {
        go(below);
        go(above);
    }
    go(below);
    points.push_back({points.back().time_s + 0.15, below});
    go(below + Vector3(0.02, 0.0, 0.0));
    go(above + Vector3(0.02, 0.0, 0.0));
    simulated::SimulationOptions options;
    options.path.emplace(std::move(points));
    return options;
}

struct Extremes {
    double energy_J = 0.0;
    double force_N = 0.0;
    int runs = 0;
    int touched = 0;
};

/// A run whose path ends with the last of its points.
void run(testing::FaultTrial &rig, double until_s, Extremes &seen) {
    bool touched = false;
    for (int tick = 0; tick < rig.ticks_in(until_s) && !rig.has_tripped(); ++tick) {
        const ServoSample sample = rig.step();
        touched |= sample.contact.touching;
        seen.energy_J = std::max(seen.energy_J, sample.generated_energy_J);
    }
    EXPECT_FALSE(rig.has_tripped()) << description(rig.last.safety);
    seen.force_N = std::max(seen.force_N, rig.max_force_N());
    seen.touched += touched ? 1 : 0;
    ++seen.runs;
}

class FalseAlarm : public ::testing::TestWithParam<double> {};

/// The servo's rate is the parameter; everything else cycles.
TEST_P(FalseAlarm, NoneWhenHandsPressAndTap) {
    std::mt19937 random(51);
    Extremes all;
    for (int tuning = 0; tuning < 3; ++tuning) {
        for (const double eta : {0.0, 0.5, 0.9}) {
            for (const Hand &hand : kHands) {
                for (const double speed_m_per_s : {0.05, 0.1, 0.2, 0.4}) {
                    testing::FaultCase what =
                        testing::random_case(random, tuning, testing::Place::plate);
                    what.servo_hz = GetParam();
                    what.start_m.y() = 0.012;
                    what.tuning.eta = eta;
                    simulated::SimulationOptions options =
                        taps_and_presses(what, speed_m_per_s, hand.depth_m);
                    options.hand = hand.parameters;
                    const double until_s = options.path->points().back().time_s + 0.05;
                    testing::FaultTrial rig(what, options, testing::HandOf::options);
                    SCOPED_TRACE(what.tuning_name + ", η " + std::to_string(eta) + ", " +
                                 hand.name + " hand at " + std::to_string(speed_m_per_s) + " m/s");
                    run(rig, until_s, all);
                }
            }
        }
    }
    EXPECT_EQ(all.runs, 108);
    EXPECT_EQ(all.touched, all.runs);
    RecordProperty("greatest_generated_mJ", std::to_string(1e3 * all.energy_J));
    RecordProperty("greatest_force_N", std::to_string(all.force_N));
}

INSTANTIATE_TEST_SUITE_P(AtRate, FalseAlarm, ::testing::Values(1000.0, 4000.0),
                         [](const auto &rate) {
                             return std::to_string(static_cast<int>(rate.param)) + "Hz";
                         });

/// A reachable stop, and the path to it: from these joint angles along one joint.
struct Way {
    const char *stop = "";
    Vector3 from_deg{Vector3::Zero()};
    int joint = 0;
    double sign = 1.0;
    double stop_deg = 0.0; ///< of the joint, or of the fold
    bool fold = false;     ///< the stop is one of q₃ − q₂
};

// q₃ − q₂ ranges from −65° to 55°; its stops are reached by moving q₃.
const std::array<Way, 6> kWays{{{"q1 highest", {76.0, 10.0, 10.0}, 0, 1.0, 90.0},
                                {"q1 lowest", {-76.0, 10.0, 10.0}, 0, -1.0, -90.0},
                                {"q2 highest", {0.0, 105.0, 105.0}, 1, 1.0, 119.0},
                                {"q3 lowest", {0.0, 10.0, -15.0}, 2, -1.0, -29.0},
                                {"fold highest", {0.0, 10.0, 51.0}, 2, 1.0, 55.0, true},
                                {"fold lowest", {0.0, 45.0, -6.0}, 2, -1.0, -65.0, true}}};

/// Slowly along the joint, through its stop, as far as the hand can.
simulated::SimulationOptions along(const Way &way, const device::PhantomGeometry &geometry) {
    constexpr double kSpeed_deg_per_s = 15.0;
    std::vector<simulated::HandPath::Point> points{
        {0.0, device::tip_position_m(geometry, way.from_deg * kRadiansPerDegree)}};
    for (int step = 0; step <= 20; ++step) {
        const Vector3 q_deg = way.from_deg + way.sign * step * Vector3::Unit(way.joint);
        points.push_back({1.15 + step / kSpeed_deg_per_s,
                          device::tip_position_m(geometry, q_deg * kRadiansPerDegree)});
    }
    points.push_back({60.0, points.back().position_m}); // and stays there
    simulated::SimulationOptions options;
    options.path.emplace(std::move(points));
    return options;
}

/// The joint's torque from the true currents is the wall's before the stop is reached.
void expect_edge_before_stop(const Way &way, const control::Tuning &tuning, double servo_hz) {
    const device::DeviceDescription device = testing::phantom_1_0();
    testing::FaultCase what;
    what.tuning = tuning;
    what.servo_hz = servo_hz;
    what.firm = true;
    what.start_m = device::tip_position_m(device.geometry, way.from_deg * kRadiansPerDegree);
    testing::FaultTrial rig(what, along(way, device.geometry));
    const double k_T = device.motor[0].torque_constant_Nm_per_A;
    const double N = device.geometry.transmission_ratio[way.joint];
    double before_stop_Nm = 0.0;
    double share = 1.0; // smallest share of the wall's torque
    bool met = false;
    for (int tick = 0; tick < rig.ticks_in(2.6) && !rig.has_tripped(); ++tick) {
        const ServoSample sample = rig.step();
        const Vector3 q = device::joint_from_motor(device.geometry, rig.truth().theta_rad);
        const double q_rad = way.fold ? q[2] - q[1] : q[way.joint];
        const double to_stop_rad = way.sign * (way.stop_deg * kRadiansPerDegree - q_rad);
        const double pushed_back_Nm = -way.sign * N * k_T * rig.truth().current_A[way.joint];
        const double depth_rad = device.edge.margin_rad - to_stop_rad;
        if (sample.safety.state == SafetyState::running && to_stop_rad > 0.0) {
            before_stop_Nm = std::max(before_stop_Nm, pushed_back_Nm);
            if (depth_rad > 0.4 * device.edge.margin_rad) {
                EXPECT_TRUE(sample.active_limits.at_edge);
                met = true;
                share = std::min(share,
                                 pushed_back_Nm / (device.edge.stiffness_Nm_per_rad * depth_rad));
            }
        }
    }
    EXPECT_FALSE(rig.has_tripped()) << description(rig.last.safety);
    EXPECT_TRUE(met);
    EXPECT_GT(before_stop_Nm, 0.2);
    EXPECT_GT(share, 0.5); // of a spring alone; the rest is ripple, friction and lag
    EXPECT_LT(rig.max_force_N(), device.limits.tip_force_N);
}

TEST(SoftEdge, ActsBeforeEveryStopInEveryMap) {
    for (const Way &way : kWays) {
        for (const double eta : {0.0, 1.0}) {
            for (const control::MotionMap map :
                 {control::MotionMap::inverse, control::MotionMap::transpose}) {
                for (const control::AlphaMode alpha :
                     {control::AlphaMode::on_the_fly, control::AlphaMode::global,
                      control::AlphaMode::by_hand}) {
                    for (const double dR_Ohm : {0.2, 0.8}) {
                        control::Tuning tuning;
                        tuning.dR_Ohm = dR_Ohm;
                        tuning.eta = eta;
                        tuning.map = map;
                        tuning.alpha_mode = alpha;
                        SCOPED_TRACE(
                            std::string(way.stop) + ", η " + std::to_string(eta) +
                            (map == control::MotionMap::inverse ? ", inverse" : ", transpose") +
                            ", dR " + std::to_string(dR_Ohm));
                        expect_edge_before_stop(way, tuning, 1000.0);
                        if (HasFailure()) {
                            return;
                        }
                    }
                }
            }
        }
    }
}

} // namespace
} // namespace springdrive::servo
