// Covers the soft wall at the edge of the workspace under a hand: before every joint's stop, with
// any tuning, and also at η = 1.
#include "base/degrees.h"
#include "device/core/phantom/kinematics.h"
#include "tests/support/devices.h"
#include "tests/support/fault_trial.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::servo {
namespace {

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
