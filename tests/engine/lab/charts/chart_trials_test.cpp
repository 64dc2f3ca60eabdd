// Covers what the charts of motion maps, of proxies and of servo rates try:
// engine/lab/charts/{motion_trial,touch_trial}.h and servo_rate_chart.cpp.
#include "base/degrees.h"
#include "base/input_error.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/rendered_force.h"
#include "engine/lab/charts/motion_trial.h"
#include "engine/lab/charts/servo_rate_chart.h"
#include "engine/lab/charts/touch_trial.h"
#include "engine/lab/loops/link_plane.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "tests/support/devices.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

namespace springdrive::charts {
namespace {

constexpr MotionMethod kInverse{control::MotionMap::inverse, control::AlphaMode::on_the_fly, 0.0};
constexpr MotionMethod kOnTheFly{control::MotionMap::transpose, control::AlphaMode::on_the_fly,
                                 0.0};

MotionMethod by_hand(double alpha_rad2_per_m2) {
    return {control::MotionMap::transpose, control::AlphaMode::by_hand, alpha_rad2_per_m2};
}

TEST(MotionTrial, ErrorOfTheInverseIsAtMostQ3MinusQ2InTheLinksPlane) {
    // docs/design.md, "Linkage and motors": exact for l₁ = l₂ and N₂ = N₃, and small depths.
    const device::DeviceDescription device = testing::phantom_1_0();
    for (const Vector3 &q_deg : {Vector3(0, 20, -15), Vector3(10, -10, 25), Vector3(-20, 5, 5)}) {
        double largest = 0.0;
        for (int i = 0; i < 3600; ++i) {
            const loops::Vector2 n = loops::direction_at(std::numbers::pi * i / 3600.0);
            const Vector3 normal = loops::link_plane(kRadiansPerDegree * q_deg[0]) * n;
            const HeldTip tip{kRadiansPerDegree * q_deg, normal, 1e-7, 0};
            largest = std::max(
                largest, control::direction_error_rad(
                             force_on_holder_N(device, control::Tuning{}, kInverse, tip), normal));
        }
        EXPECT_NEAR(largest / kRadiansPerDegree, std::abs(q_deg[2] - q_deg[1]), 1e-3)
            << q_deg.transpose();
    }
}

TEST(MotionTrial, ErrorOfTheTransposeIsRoundOffAndTheEncodersQuantum) {
    for (const device::DeviceDescription &device :
         {testing::phantom_1_0(), testing::phantom_premium_1_5()}) {
        for (const Vector3 &q_rad : workspace_angles_rad(device, 4)) {
            for (const Vector3 &normal : spread_normals(10)) {
                const auto error_rad = [&](int counts) {
                    return control::direction_error_rad(
                        force_on_holder_N(device, control::Tuning{}, kOnTheFly,
                                          {q_rad, normal, 1e-3, counts}),
                        normal);
                };
                ASSERT_LT(error_rad(0), 1e-12);
                // Half a count at a joint is π/(4096·11); the links amplify it no more than
                // tenfold.
                ASSERT_LT(error_rad(4096), 10.0 * std::numbers::pi / (4096.0 * 11.0));
            }
        }
    }
}

TEST(MotionTrial, StiffnessIsThatOf27And21) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const Vector3 q_rad = kRadiansPerDegree * Vector3(0, 20, -15);
    const loops::PlanarStiffness known = loops::planar_stiffness(device, control::Tuning{}, q_rad);
    for (const double angle : {0.0, 0.7, 2.0}) {
        const loops::Vector2 n = loops::direction_at(angle);
        const HeldTip tip{q_rad, loops::link_plane(0.0) * n, 1e-7, 0};
        const double transpose = tip.normal.dot(
            force_on_holder_N(device, control::Tuning{}, by_hand(known.alpha_rad2_per_m2), tip));
        EXPECT_NEAR(transpose / tip.depth_m / known.transpose(0, 0), 1.0, 1e-6);
        const double inverse =
            tip.normal.dot(force_on_holder_N(device, control::Tuning{}, kInverse, tip));
        EXPECT_NEAR(inverse / tip.depth_m / n.dot(known.inverse * n), 1.0, 1e-6);
    }
}

TEST(MotionTrial, InverseWithoutASolutionGivesNoForce) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const Vector3 aligned_rad = kRadiansPerDegree * Vector3(0, -45, 45);
    EXPECT_TRUE(force_on_holder_N(device, control::Tuning{}, kInverse,
                                  {aligned_rad, Vector3::UnitY(), 1e-3, 0})
                    .isZero(0.0));
}

TEST(MotionTrial, StableUpToTheBoundAndUnstableFarAboveIt) {
    const device::DeviceDescription device = testing::phantom_1_0();
    for (const Vector3 &q_rad : workspace_angles_rad(device, 3)) {
        EXPECT_TRUE(is_stable_at(device, control::Tuning{}, kInverse, q_rad));
        EXPECT_TRUE(is_stable_at(device, control::Tuning{}, kOnTheFly, q_rad));
    }
    // One mode's loop gain grows with α: it becomes unstable at one α and remains so above it.
    const Vector3 q_rad = kRadiansPerDegree * Vector3(0, 20, -15);
    bool was_stable = true;
    for (int i = 0; i < 42; ++i) {
        const double alpha = 2000.0 * std::pow(1.1, i); // up to 1e5
        const bool stable = is_stable_at(device, control::Tuning{}, by_hand(alpha), q_rad);
        EXPECT_TRUE(was_stable || !stable) << alpha;
        was_stable = stable;
    }
    EXPECT_FALSE(was_stable);
}

TEST(MotionTrial, PlacesAreInReachAndNormalsEven) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const std::vector<Vector3> places_rad = workspace_angles_rad(device, 5);
    EXPECT_GT(places_rad.size(), 60U);
    for (const Vector3 &q_rad : places_rad) {
        EXPECT_TRUE(device.joint_limits.allow(q_rad));
    }
    Vector3 sum = Vector3::Zero();
    for (const Vector3 &normal : spread_normals(100)) {
        ASSERT_NEAR(normal.norm(), 1.0, 1e-15);
        sum += normal;
    }
    EXPECT_LT(sum.norm(), 2.0);
}

constexpr std::size_t kTips = 3000;

TouchErrors proxy_errors(const TouchTrial &trial, const contact::HapticSurface &surface) {
    std::vector<RenderedTouch> touches(trial.tips.size());
    follow_with_proxy(surface, trial.tips, touches);
    return touch_errors(trial.tips, touches);
}

TouchErrors penalty_errors(const TouchTrial &trial, const contact::TriangleSoup &soup) {
    std::vector<RenderedTouch> touches(trial.tips.size());
    rig::ClosestPointFinder mesh(soup);
    push_to_closest_point(mesh, trial.tips, touches);
    return touch_errors(trial.tips, touches);
}

contact::HapticSurface primitive_of(const TouchTrial &trial) {
    contact::TriangleSoup material_only;
    material_only.materials = {{"primitive", 0.0}};
    return contact::HapticSurface(std::move(material_only), {*trial.primitive});
}

/// The largest angle at the centre between a triangle's normal and one of its corners.
double half_angle_rad(const contact::TriangleSoup &soup) {
    double largest = 0.0;
    for (const auto &[a, b, c] : soup.triangles) {
        const Vector3 &corner = soup.vertices_m[a];
        const Vector3 normal =
            (soup.vertices_m[b] - corner).cross(soup.vertices_m[c] - corner).normalized();
        largest = std::max(largest, std::acos(normal.dot(corner.normalized())));
    }
    return largest;
}

TEST(RenderedTouch, ErrorOnASphereMeshIsTheSagittaAndTheHalfAngle) {
    const TouchTrial trial = sphere_trial(kTips);
    for (const int divisions : {3, 4, 5}) {
        const contact::TriangleSoup soup = trial.mesh(divisions);
        const double angle = half_angle_rad(soup);
        for (const TouchErrors &errors :
             {proxy_errors(trial, contact::HapticSurface(soup)), penalty_errors(trial, soup)}) {
            const double sagitta_m = rig::kTestSphereRadius_m * (1.0 - std::cos(angle));
            EXPECT_LE(errors.depth_m, sagitta_m * (1.0 + 1e-9));
            EXPECT_GE(errors.depth_m, 0.5 * sagitta_m); // triangles differ by 1.2 in their edges
            EXPECT_LE(errors.direction_rad, angle * (1.0 + 1e-9));
            EXPECT_GE(errors.direction_rad, 0.5 * angle);
            EXPECT_FALSE(errors.pops_through);
        }
    }
}

TEST(RenderedTouch, ErrorsFallWithTheTriangles) {
    // Depths as 1/N, directions as 1/√N: four times the triangles are a quarter and a half.
    for (const TouchTrial &trial : {sphere_trial(kTips), organic_trial(kTips)}) {
        const TouchErrors coarse = proxy_errors(trial, contact::HapticSurface(trial.mesh(4)));
        const TouchErrors fine = proxy_errors(trial, contact::HapticSurface(trial.mesh(5)));
        EXPECT_NEAR(std::log2(coarse.depth_m / fine.depth_m), 2.0, 0.25) << trial.what;
        EXPECT_NEAR(std::log2(coarse.direction_rad / fine.direction_rad), 1.0, 0.25) << trial.what;
    }
}

TEST(RenderedTouch, OfAPrimitiveIsExact) {
    const TouchErrors errors = proxy_errors(sphere_trial(kTips), primitive_of(sphere_trial(1)));
    EXPECT_LT(errors.depth_m, 1e-16); // round-off of 50 mm
    EXPECT_LT(errors.direction_rad, 1e-7);
    const TouchErrors plate =
        proxy_errors(thin_plate_trial(kTips), primitive_of(thin_plate_trial(1)));
    EXPECT_LT(plate.depth_m, 1e-16);
}

TEST(RenderedTouch, OnACurvedMeshFollowsItsNormals) {
    const TouchTrial trial = sphere_trial(kTips);
    const contact::TriangleSoup coarse = trial.mesh(3);
    const TouchErrors flat = proxy_errors(trial, contact::HapticSurface(coarse));
    const TouchErrors curved =
        proxy_errors(trial, contact::HapticSurface(bent(coarse, trial.normal)));
    EXPECT_LT(curved.depth_m, 0.02 * flat.depth_m);
    // Half of the allowed difference of 0.5 degrees between neighbouring facets, except at corners.
    EXPECT_LT(curved.direction_rad, 0.5 * std::numbers::pi / 180.0);
}

TEST(RenderedTouch, PenaltyPopsThroughBeyondTheMiddleAndTheProxyNever) {
    const Vector3 half_m = rig::thin_plate_half_size_m();
    for (const double beyond_m : {-1e-6, 1e-6}) {
        TouchTrial trial = thin_plate_trial(1);
        const Vector3 top_m(0.01, half_m.y(), 0.005);
        trial.tips = {
            {top_m - (half_m.y() + beyond_m) * Vector3::UnitY(), top_m, Vector3::UnitY()}};
        EXPECT_EQ(penalty_errors(trial, trial.mesh(3)).pops_through, beyond_m > 0.0);
        EXPECT_FALSE(proxy_errors(trial, contact::HapticSurface(trial.mesh(3))).pops_through);
    }
}

TEST(RenderedTouch, ErrorOfAMissedContactIsItsWholeDepth) {
    const std::vector<rig::PressedTip> tips = rig::tips_in_sphere(10);
    const std::vector<RenderedTouch> nothing(tips.size());
    const TouchErrors errors = touch_errors(tips, nothing);
    double deepest_m = 0.0;
    for (const rig::PressedTip &tip : tips) {
        deepest_m = std::max(deepest_m, tip.depth_m());
    }
    EXPECT_DOUBLE_EQ(errors.depth_m, deepest_m); // rank 10 of 10
    EXPECT_EQ(errors.direction_rad, 0.0);
}

TEST(RenderedTouch, TrialsHaveTheStatedNumberOfTriangles) {
    EXPECT_EQ(sphere_trial(1).mesh(kCoarsestDivisions).triangles.size(), 1280U);
    EXPECT_EQ(thin_plate_trial(1).mesh(kCoarsestDivisions).triangles.size(), 768U);
    const contact::MeshReport report = contact::HapticSurface(thin_plate_trial(1).mesh(3)).report();
    EXPECT_EQ(report.closed_components, 1U);
    EXPECT_EQ(report.inward_components, 0U);
}

loops::SpringDrive drive_at(double rate_Hz, double delay) {
    return {testing::phantom_1_0().motor[1], control::Tuning{}, 1.0 / rate_Hz, delay};
}

// The band that the header states.
constexpr double kMinJudged_Hz = 2.0;
constexpr double kMaxJudged_Hz = 100.0;

/// The same error from the sampled closed form, instead of the simulated motor.
double predicted_error(const loops::SpringDrive &drive, int points) {
    double sum = 0.0;
    for (int i = 0; i < points; ++i) {
        const double omega = 2.0 * std::numbers::pi * kMinJudged_Hz *
                             std::pow(kMaxJudged_Hz / kMinJudged_Hz, i / (points - 1.0));
        const std::complex<double> truth = loops::analytic_stiffness(drive, omega);
        sum += std::norm((loops::sampled_stiffness(drive, omega) - truth) / truth);
    }
    return std::sqrt(sum / points);
}

TEST(ServoRateTrial, MeasuredErrorIsThatOfTheSampledForm) {
    for (const int delay : {0, 2}) {
        for (const double rate_Hz : {500.0, 4000.0}) {
            const loops::SpringDrive drive = drive_at(rate_Hz, delay);
            // The sweep's own error is 5e-5 of each part; its frequencies move by 1/2000.
            EXPECT_NEAR(stiffness_error(drive, 8), predicted_error(drive, 8), 1e-3);
        }
    }
}

TEST(ServoRateTrial, ErrorGoesToZeroAtFirstOrder) {
    for (const int delay : {0, 1}) {
        const double coarse = stiffness_error(drive_at(5000.0, delay), 6);
        const double fine = stiffness_error(drive_at(20'000.0, delay), 6);
        EXPECT_NEAR(std::log2(coarse / fine) / 2.0, 1.0, 0.05) << delay;
        EXPECT_LT(fine, 0.02);
    }
}

TEST(ServoRateTrial, DirectionTendsToThatOfTheContinuousServo) {
    // The limit is the error due to λ; convergence is of first order in T.
    const device::DeviceDescription device = testing::phantom_1_0();
    const auto error = [&](double rate_Hz) {
        return perceived_direction_error_rad(device, control::Tuning{}, 1.0 / rate_Hz);
    };
    const double limit = error(1e7);
    EXPECT_NEAR(std::log2((error(8000.0) - limit) / (error(16'000.0) - limit)), 1.0, 0.05);
    control::Tuning quick;
    quick.lambda_rad_per_s = 1e5;
    EXPECT_LT(perceived_direction_error_rad(device, quick, 1e-7), 0.03 * limit);
}

TEST(ServoRateTrial, LateAndSlowServosAreUnstable) {
    const device::DeviceDescription device = testing::phantom_1_0();
    EXPECT_TRUE(is_stable_on_all_motors(device, control::Tuning{}, 1e-3, 0));
    EXPECT_TRUE(is_stable_on_all_motors(device, control::Tuning{}, 1e-3, 1));
    EXPECT_FALSE(is_stable_on_all_motors(device, control::Tuning{}, 4e-3, 2));
    EXPECT_FALSE(is_stable_on_all_motors(device, control::Tuning{}, 2e-2, 0));
}

TEST(ServoRateTrial, TimesAServoThatRuns) {
    ChartSetting setting;
    setting.device = testing::phantom_1_0();
    setting.repeats = 1;
    EXPECT_GT(cost_of_servo_tick(setting).min_ns, 0.0);
    setting.device.limits.tip_speed_m_per_s = 1e-4; // the hand is faster
    EXPECT_THROW(static_cast<void>(cost_of_servo_tick(setting)), InputError);
}

} // namespace
} // namespace springdrive::charts
