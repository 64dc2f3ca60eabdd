// Covers engine/servo/servo_loop.cpp: the whole signal path on the simulated device.
#include "engine/servo/servo_loop.h"

#include "device/core/phantom/dynamics.h"
#include "device/core/phantom/kinematics.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/control/coupling.h"
#include "engine/control/motion_control.h"
#include "tests/engine/servo/servo_rig.h"
#include "tests/support/devices.h"
#include "tests/support/surfaces.h"
#include "tests/support/tunings.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::servo {
namespace {

using testing::following;
using testing::kPeriod_s;
using testing::kStart_m;
using testing::kStartUp_s;
using testing::plate;
using testing::Rig;

/// Hits the plate and slides on it, with all effects; tip and currents after every tick.
struct Strike {
    std::vector<Vector3> tip_m;
    std::vector<Vector3> current_A;
};

Strike strike(double longest_step_s) {
    simulated::SimulationOptions options = following({{0.0, kStart_m},
                                                      {0.60, Vector3(0.01, 0.003, 0.005)},
                                                      {0.65, Vector3(0.01, -0.012, 0.005)},
                                                      {0.80, Vector3(0.02, -0.012, 0.005)}});
    options.effects = simulated::PlantEffects{};
    options.quantised_encoders = false; // one count would change the run
    options.longest_step_s = longest_step_s;
    Rig rig(options, plate());
    rig.run(kStartUp_s);
    Strike strike;
    for (int tick = 0; tick < 800; ++tick) {
        rig.tick();
        strike.tip_m.push_back(rig.truth().tip_m);
        strike.current_A.push_back(rig.truth().current_A);
    }
    return strike;
}

TEST(ServoLoop, ThePlantsDefaultStepSufficesForHardContact) {
    // What SimulationOptions::longest_step_s promises; friction makes the step first order here.
    const double step_s = simulated::SimulationOptions{}.longest_step_s;
    const Strike usual = strike(step_s);
    const Strike fine = strike(step_s / 50);
    double tip_m = 0.0;
    double current_A = 0.0;
    double largest_A = 0.0;
    for (std::size_t tick = 0; tick < fine.tip_m.size(); ++tick) {
        tip_m = std::max(tip_m, (usual.tip_m[tick] - fine.tip_m[tick]).norm());
        current_A = std::max(current_A, (usual.current_A[tick] - fine.current_A[tick]).norm());
        largest_A = std::max(largest_A, fine.current_A[tick].norm());
    }
    EXPECT_GT(largest_A, 1.0); // it hit the plate
    EXPECT_LT(tip_m, 2e-6);
    EXPECT_LT(current_A, 1e-3 * largest_A);
    EXPECT_GT(tip_m, 1e-9); // the two differ
}

struct StaticContact {
    double stiffness_N_per_m = 0.0; ///< mean force over mean penetration of the true tip
    double predicted_N_per_m = 0.0; ///< (1 − η) α K_DC
    double force_angle_rad = 0.0;   ///< between mean hand force and the plate's normal
    double penetration_m = 0.0;
};

/// Presses on the plate at `depth_m` below its top and takes means over the last half second.
StaticContact press(double eta, bool quantised) {
    constexpr double kDepth_m = 0.012;
    simulated::SimulationOptions options = following({{0.0, kStart_m},
                                                      {0.6, Vector3(0.01, 0.003, 0.005)},
                                                      {1.2, Vector3(0.01, -kDepth_m, 0.005)}});
    options.quantised_encoders = quantised;
    Rig rig(options, plate());
    rig.inputs.tuning.eta = eta;
    rig.run(kStartUp_s + 3.0);
    Vector3 force = Vector3::Zero();
    double penetration = 0.0;
    double predicted = 0.0;
    constexpr int kTicks = 500;
    for (int i = 0; i < kTicks; ++i) {
        const ServoSample sample = rig.tick();
        EXPECT_EQ(sample.contact.active_constraints, 1);
        force -= rig.truth().hand_force_N / kTicks;
        penetration -= rig.truth().tip_m.y() / kTicks;
        const control::Coupling c =
            control::coupling(rig.device().description().motor[0], rig.inputs.tuning, kPeriod_s,
                              rig.device().delay_periods());
        predicted += control::tip_stiffness_N_per_m(c, sample.alpha_rad2_per_m2, eta) / kTicks;
    }
    return {force.norm() / penetration, predicted,
            std::atan2(force.cross(Vector3::UnitY()).norm(), force.y()), penetration};
}

TEST(ServoLoop, StaticTipStiffnessIsAlphaTimesKDC) {
    // (13), (27), (30). Exact except for the proxy's clearance of 10 nm and the change of J with x.
    // With encoders the law's tip position is off by up to half a count of each joint: as an angle,
    // that over the penetration. The stiffness error is at most the same share of one joint's
    // force.
    const double half_count_m = 0.5 * 2.0 * std::numbers::pi / 4096 / 11.2 * 0.16;
    for (const bool quantised : {false, true}) {
        for (const double eta : {0.0, 0.25, 0.5, 0.75}) {
            SCOPED_TRACE("η " + std::to_string(eta) + (quantised ? ", with encoders" : ""));
            const StaticContact contact = press(eta, quantised);
            EXPECT_GT(contact.penetration_m, 5e-4);
            EXPECT_NEAR(contact.stiffness_N_per_m / contact.predicted_N_per_m, 1.0,
                        quantised ? 0.01 : 0.001);
            EXPECT_LT(contact.force_angle_rad,
                      quantised ? std::sqrt(3.0) * half_count_m / contact.penetration_m : 1e-3);
        }
    }
}

TEST(ServoLoop, RenderedForceIsWhatTheHandFeels) {
    Rig rig(following({{0.0, kStart_m}, {1.0, Vector3(0.0, -0.01, 0.0)}}), plate());
    rig.run(kStartUp_s + 2.5);
    Vector3 rendered = Vector3::Zero();
    Vector3 felt = Vector3::Zero();
    for (int i = 0; i < 500; ++i) {
        rendered += rig.tick().tip_force_N / 500;
        felt -= rig.truth().hand_force_N / 500;
    }
    EXPECT_GT(felt.norm(), 1.0);
    // At rest the windings' force equals the hand's; J is evaluated at the counts, not at the true
    // angles.
    EXPECT_LT((rendered - felt).norm(), 0.002 * felt.norm());
}

/// The maximum force on a hand that moves at a constant 30 mm/s along an axis, in newtons.
double max_force_on_a_slow_hand_N(const char *tuning, const Vector3 &axis) {
    Rig rig(following({{0.0, kStart_m}, {0.7, kStart_m}, {2.7, kStart_m + 0.06 * axis}}));
    rig.inputs.tuning = testing::tuning(tuning);
    rig.run(kStartUp_s + 1.2);
    double max_N = 0.0;
    for (int i = 0; i < 1400; ++i) {
        rig.tick();
        max_N = std::max(max_N, rig.truth().hand_force_N.norm());
    }
    EXPECT_GT(rig.truth().tip_velocity_m_per_s.dot(axis), 0.02); // not vacuous
    return max_N;
}

TEST(ServoLoop, ForceInFreeSpaceIsSmall) {
    // The remainder is mostly the ripple of single encoder counts, proportional to 1/dR and λ.
    for (const Vector3 &axis : {Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1)}) {
        EXPECT_LT(max_force_on_a_slow_hand_N("soft", axis), 0.05) << axis.transpose();
        EXPECT_LT(max_force_on_a_slow_hand_N("firm", axis), 0.05) << axis.transpose();
        // The stiffest tuning trades transparency for stiffness: the force of a count is up to
        // that of the inductive spring (4), K_L count N/l, largest at the base motor.
        const device::DeviceDescription device = testing::phantom_1_0();
        const double one_count_N = device::inductive_stiffness_Nm_per_rad(device.motor[0]) * 2.0 *
                                   std::numbers::pi / device.encoder_counts_per_turn *
                                   device.geometry.transmission_ratio[0] /
                                   device.geometry.upper_arm_m;
        EXPECT_LT(max_force_on_a_slow_hand_N("stable_only_1kHz", axis), one_count_N)
            << axis.transpose();
    }
}

struct Inertia {
    double measured_kg = 0.0;
    double predicted_kg = 0.0;
};

/// Oscillates the tip along x in free space and fits force to acceleration: the inertia beyond that
/// of tip and rotors is added by the loop's lag.
Inertia added_inertia(const control::Tuning &tuning, double period_s, int delay) {
    constexpr double kShake_rad_per_s = 2.0 * std::numbers::pi * 4.0;
    constexpr double kReach_m = 0.02;
    std::vector<simulated::HandPath::Point> points;
    for (int i = 0; i <= 3000; ++i) {
        const double t = i * 1e-3;
        const double reach_m = kReach_m * std::min(1.0, 2.0 * t); // avoids a step at the start
        points.push_back({t, kStart_m + Vector3(reach_m * std::sin(kShake_rad_per_s * t), 0, 0)});
    }
    simulated::SimulationOptions options = following(std::move(points));
    options.servo_period_s = period_s;
    options.delay_periods = delay;
    options.hand = {0.0, 40.0, 20e3, 1e3, 1.0}; // keeps the tip close to the path
    Rig rig(options);
    rig.inputs.tuning = tuning;
    rig.run(kStartUp_s + 1.0);
    // Least squares of F versus a over whole oscillations; the part in phase with velocity cancels.
    const device::DeviceDescription &device = rig.device().description();
    const device::LinkageMoments moments =
        device::linkage_moments(device.geometry, device.inertia, 0.0);
    double own_kg = 0.0; // of links and rotors along x, mean over the oscillations
    double force_acceleration = 0.0;
    double acceleration_squared = 0.0;
    double predicted = 0.0;
    const int ticks = static_cast<int>(std::round(1.5 / period_s));
    const control::Coupling c = control::coupling(device.motor[0], tuning, period_s, delay);
    for (int i = 0; i < ticks; ++i) {
        const ServoSample sample = rig.tick();
        // Time of the mean force since the start of the path.
        const double t = rig.truth().time_s - 0.5 * period_s - kStartUp_s;
        const double a =
            -kReach_m * kShake_rad_per_s * kShake_rad_per_s * std::sin(kShake_rad_per_s * t);
        force_acceleration += rig.truth().hand_force_N.x() * a;
        acceleration_squared += a * a;
        const Vector3 q_rad = device::joint_from_motor(device.geometry, sample.theta_rad);
        const Vector3 theta_per_x = device::motor_jacobian(device.geometry, q_rad).inverse().col(0);
        const Vector3 q_per_x = device::joint_from_motor(device.geometry, theta_per_x);
        own_kg += (q_per_x.dot(device::mass_matrix(moments, q_rad) * q_per_x) +
                   device.motor[0].rotor_inertia_kg_m2 * theta_per_x.squaredNorm()) /
                  ticks;
        predicted += c.added_inertia_kg_m2 * theta_per_x.squaredNorm() / ticks;
    }
    return {force_acceleration / acceleration_squared - own_kg, predicted};
}

TEST(ServoLoop, AddedInertiaIsThatOfTheLoopsLag) {
    // k_T² τ/dR per motor, τ = T (a/(1 − a) + 1 + d): the slope at zero frequency. At 4 Hz the
    // winding's lag, L/dR, and the filter's curvature contribute less than a few per cent.
    for (const double dR : {0.2, 0.4, 0.8}) {
        for (const double lambda : {500.0, 2000.0}) {
            for (const int delay : {0, 1}) {
                control::Tuning tuning;
                tuning.dR_Ohm = dR;
                tuning.lambda_rad_per_s = lambda;
                const Inertia inertia = added_inertia(tuning, 1e-3, delay);
                EXPECT_NEAR(inertia.measured_kg / inertia.predicted_kg, 1.0, 0.10)
                    << "dR " << dR << " λ " << lambda << " d " << delay << ": "
                    << inertia.measured_kg << " kg, predicted " << inertia.predicted_kg;
            }
        }
    }
}

TEST(ServoLoop, SlidingOnThePlateIsFrictionless) {
    // The tangential force while sliding at 30 mm/s is that of free space, not of a brake.
    Rig rig(following({{0.0, kStart_m},
                       {0.8, Vector3(-0.03, -0.01, 0.0)},
                       {1.2, Vector3(-0.03, -0.01, 0.0)},
                       {3.2, Vector3(0.03, -0.01, 0.0)}}),
            plate());
    rig.run(kStartUp_s + 1.8);
    Vector3 mean = Vector3::Zero();
    for (int i = 0; i < 1000; ++i) {
        const ServoSample sample = rig.tick();
        ASSERT_TRUE(sample.contact.touching);
        mean += rig.truth().hand_force_N / 1000;
    }
    EXPECT_LT(mean.y(), -1.0);
    EXPECT_LT(std::abs(mean.x()), 0.02);
}

TEST(ServoLoop, TheOtherMapIsEvaluatedInTheSameState) {
    Rig rig(following({{0.0, kStart_m}, {1.0, Vector3(0.03, -0.01, 0.02)}}), plate());
    rig.run(kStartUp_s + 2.0);
    const ServoSample transpose = rig.tick();
    EXPECT_LT(transpose.transpose_error_rad, 1e-6);
    EXPECT_GT(transpose.inverse_error_rad, 0.02);
    rig.inputs.tuning.map = control::MotionMap::inverse;
    const ServoSample inverse = rig.tick();
    EXPECT_EQ(inverse.tuning.map, control::MotionMap::inverse);
    EXPECT_LT(inverse.transpose_error_rad, 1e-6);
    EXPECT_NEAR(inverse.inverse_error_rad, transpose.inverse_error_rad, 0.02);
    // Given time, the rendered force takes the inverse map's direction.
    rig.run(1.0);
    const ServoSample settled = rig.tick();
    EXPECT_NEAR(settled.rendered_error_rad, settled.inverse_error_rad, 0.03);
}

TEST(ServoLoop, ATransparentSurfaceHasNoForceDirection) {
    // η = 1: the set-point is the tip, and θ_Sd − θ is round-off.
    Rig rig(following({{0.0, kStart_m}, {1.0, Vector3(0.0, -0.01, 0.0)}}), plate());
    rig.inputs.tuning.eta = 1.0;
    rig.run(kStartUp_s + 1.5);
    const ServoSample sample = rig.tick();
    EXPECT_TRUE(sample.contact.touching);
    EXPECT_TRUE(std::isnan(sample.inverse_error_rad));
    EXPECT_TRUE(std::isnan(sample.transpose_error_rad));
}

TEST(ServoLoop, KeepsItsTuningForAnInvalidOne) {
    Rig rig({}, plate());
    rig.run(kStartUp_s);
    const Vector3 before = rig.tick().command.cancelled_resistance_Ohm;
    rig.inputs.tuning.dR_Ohm = NAN;
    EXPECT_EQ(rig.tick().command.cancelled_resistance_Ohm, before);
    rig.inputs.tuning.dR_Ohm = -1.0;
    EXPECT_EQ(rig.tick().command.cancelled_resistance_Ohm, before);
    rig.inputs.tuning.dR_Ohm = 1.0;
    rig.run(1.0);
    EXPECT_DOUBLE_EQ(rig.tick().command.cancelled_resistance_Ohm[0], 1.18);
}

TEST(ServoLoop, AChangeOfTuningInContactCausesNoForceStep) {
    // A switch from one tuning to another while the hand presses: the rendered force stays between
    // the two steady forces, except for the overshoot of the hand's own spring, here well below a
    // newton.
    for (const auto &[from, to] :
         {std::pair("soft", "stable_only_1kHz"), std::pair("stable_only_1kHz", "soft"),
          std::pair("soft", "firm")}) {
        Rig rig(following({{0.0, kStart_m}, {1.0, Vector3(0.0, -0.01, 0.0)}}), plate());
        rig.inputs.tuning = testing::tuning(from);
        rig.run(kStartUp_s + 2.0);
        const double before_N = rig.tick().tip_force_N.norm();
        rig.inputs.tuning = testing::tuning(to);
        double max_N = 0.0;
        for (int i = 0; i < 1000; ++i) {
            max_N = std::max(max_N, rig.tick().tip_force_N.norm());
        }
        const double after_N = rig.tick().tip_force_N.norm();
        EXPECT_GT(before_N, 1.0);
        EXPECT_LT(max_N, std::max(before_N, after_N) + 1.0) << from << " to " << to;
    }
}

/// N invkin(x₀) of (18).
Vector3 set_point_rad(const device::DeviceDescription &device, const Vector3 &x0_m) {
    return device::motor_from_joint(device.geometry,
                                    device::joint_angles_rad(device.geometry, x0_m).value());
}

/// Held by the hand at `kStart_m`, which is x₀, too.
struct FixedRig : Rig {
    FixedRig() : Rig(following({{0.0, kStart_m}, {1e3, kStart_m}})) {
        inputs.tuning.map = control::MotionMap::inverse;
        run(kStartUp_s);
        inputs.fixed_x0_m = last.tip_m;
        run(0.2); // the new scene's offset has decayed
    }
};

TEST(ServoLoop, HoldsAFixedPointInAllDirectionsAndAddsTheExcitation) {
    FixedRig rig;
    const Vector3 x0_m = *rig.inputs.fixed_x0_m;
    const control::HapticLaw law(rig.device().description());
    for (int tick = 0; tick < 400; ++tick) {
        const Vector3 excitation_V = Vector3(0.3, -0.2, 0.1) * std::sin(0.1 * tick);
        rig.inputs.excitation_V = excitation_V;
        const ServoSample &now = rig.tick();
        ASSERT_EQ(now.safety.state, SafetyState::running) << description(now.safety);
        ASSERT_EQ(now.contact.x0_m, x0_m);
        ASSERT_EQ(now.x_Sd_m, x0_m);
        ASSERT_FALSE(now.active_limits.holds_force());
        // (18), (10) with a set-point at rest:
        const Vector3 set_rad = set_point_rad(rig.device().description(), x0_m);
        const control::Tuning &tuning = now.tuning;
        const Vector3 law_V = tuning.K_P_V_per_rad * (set_rad - now.theta_rad) -
                              tuning.K_D_Vs_per_rad * now.theta_rate_rad_per_s;
        EXPECT_LT((now.command.e_W_V - law_V - excitation_V).norm(), 1e-9);
    }
    // Pushed to any side, the tip is pulled back.
    for (const double side : {1.0, -1.0}) {
        rig.inputs.excitation_V = Vector3(side, 0.0, 0.0);
        rig.run(0.3);
        EXPECT_GT(side * rig.last.theta_rad[0],
                  side * set_point_rad(rig.device().description(), x0_m)[0]);
        EXPECT_LT(side * (rig.last.command.e_W_V[0] - side), 0.0);
    }
}

TEST(ServoLoop, LimitsAnExcitationLikeEveryCommand) {
    FixedRig absurd;
    absurd.inputs.excitation_V = Vector3(500.0, 0.0, 0.0);
    const device::DeviceDescription &device = absurd.device().description();
    for (int tick = 0; tick < 300; ++tick) {
        const ServoSample &now = absurd.tick();
        ASSERT_LE(std::abs(now.command.e_W_V[0]), device.motor[0].supply_V);
        ASSERT_LE(now.tip_force_N.norm(), 1.05 * device.limits.tip_force_N);
    }
    EXPECT_TRUE(absurd.has_tripped() || absurd.last.active_limits.holds_force());

    FixedRig unreal;
    unreal.inputs.excitation_V = Vector3(0.0, std::nan(""), 0.0);
    unreal.tick();
    EXPECT_TRUE(unreal.has_tripped());
    EXPECT_EQ(unreal.last.command.mode, device::CommandMode::brake);

    FixedRig nowhere;
    nowhere.inputs.fixed_x0_m = Vector3(std::nan(""), 0.0, 0.0);
    nowhere.tick();
    EXPECT_TRUE(nowhere.has_tripped());
}

} // namespace
} // namespace springdrive::servo
